// Meshes and samples that are opened, files that are saved.

import { byId, h } from "./dom.js";
import { plural } from "./format.js";
import { download } from "./panels/export-menu.js";
import { FLAT, SURFACE } from "./view-names.js";

/** Projects bring settings of their own. The engine tells them by the same word near their beginning. */
const isProject = ({ bytes }) => Boolean(bytes) && new TextDecoder().decode(bytes.subarray(0, 200)).includes('"cutflow_project"');

/** `page` holds the parts of the page, `act` what people do with them. */
export function files(page, act) {
  const { now } = page;
  /** What is still to be done with the first document that a person opens, null for nothing. */
  let first = null;

  /** `task()` is done once, after a person has opened the first mesh; a project or another sample that is opened before ends the wait. */
  function bringToFirst(task) {
    first = task;
  }

  /** `isOwn` where the page opens it of its own accord. */
  async function opening(name, open, isOwn = false) {
    page.status.show({ state: "loading", step: 0, text: `Loading ${name}` });
    const answer = await page.waits.answer(`Loading ${name}`, "Opening was cancelled.", open);
    // The engine says how it went; a refused file leaves the document before it in place.
    const isOpen = answer.events.some((event) => event.type === "mesh");
    if (isOpen && !isOwn && first) {
      const task = first;
      first = null;
      if (!isProject(page.client.document)) await task();
    }
    return isOpen;
  }

  async function openFile(file, left) {
    if (file.type.startsWith("image/")) {
      page.texture.take(file);
      return;
    }
    if (left > 0) page.say(`Opening ${file.name}. ${plural(left, "other file was", "other files were")} left out: one mesh at a time.`);
    try {
      await opening(file.name, async () => page.client.openMesh(file.name, new Uint8Array(await file.arrayBuffer())));
    } catch (reason) {
      // The browser may refuse to read a file that was moved, or a folder.
      page.waits.hide();
      const event = {
        what: `${file.name} cannot be read.`,
        where: String(reason?.message ?? reason),
        what_to_do: "Check that it is a file, that it still exists and that you may read it, then open it again.",
      };
      page.handlers.error(event);
      page.status.show({ state: "error", step: 0, text: `Error: ${event.what}` });
    }
  }

  function openSample(name, isOwn = false) {
    // Who chooses a sample brings no mesh.
    if (!isOwn) first = null;
    const option = now.samples.options.find((sample) => sample.name === name);
    return opening(option?.label ?? name, () => page.client.openSample(name), true);
  }

  function showSamples() {
    const { options } = now.samples;
    const current = page.client.document ? (page.client.document.sample ?? null) : now.samples.current;
    const select = byId("sample");
    const isKnown = options.some(({ name }) => name === current);
    select.replaceChildren(
      ...(isKnown ? [] : [h("option", { value: "", disabled: true, hidden: true }, "Sample")]),
      ...options.map(({ name, label }) => h("option", { value: name }, label)),
    );
    select.value = isKnown ? current : "";
  }

  async function save(kind) {
    const picture = { "Surface picture (PNG)": SURFACE, "Pattern picture (PNG)": FLAT }[kind];
    if (picture !== undefined) {
      const blob = await page.views.picture(picture, page.exports.scale());
      const stem = now.mesh.name.replace(/\.[^.]*$/, "");
      if (blob) download(`${stem}-${picture === SURFACE ? "surface" : "pattern"}.png`, blob);
      else page.say("There is no picture yet.");
      return;
    }
    const { file } = await page.waits.answer(`Making ${kind}`, `${kind} was cancelled.`, () => page.client.exportFile(kind));
    if (file) download(file.name, new Blob([file.bytes], { type: file.mime }));
  }

  return { bringToFirst, opening, openFile, openSample, showSamples, save };
}
