// Links that bring a setting back: the sample, the method, every parameter that opening it would not set, and how it is
// looked at: the camera, the field, the texture.

import { byId, popover } from "../dom.js";

const PREFIX = "p.";
/** Longer links are cut short by mail programs and refused by hosts. */
const MOST_BYTES = 8192;
/** Digits of a camera: finer than a pixel. */
const DIGITS = 3;

/** What the address of the page asks for. */
export function readAddress() {
  const query = new URLSearchParams(location.search);
  const values = {};
  for (const [key, value] of query) if (key.startsWith(PREFIX)) values[key.slice(PREFIX.length)] = value;
  return {
    sample: query.get("sample"),
    method: query.get("method") ?? "cutflow",
    renderer: query.get("renderer"),
    run: query.get("run") !== "0",
    values,
    view: poseFrom(query.get("view")),
    field: query.get("field"),
    look: { texture: query.get("texture"), atlas: query.get("atlas") },
    embed: query.get("embed") === "1",
    /** The stage that Learn opens at, null where it stays closed. */
    stage: query.get("learn") === "1" || query.has("stage") ? Math.max(1, Math.trunc(Number(query.get("stage"))) || 1) : null,
  };
}

/** Six numbers of a camera, null for anything else. */
function poseFrom(text) {
  const pose = (text ?? "").split(",").map((number) => (number.trim() === "" ? NaN : Number(number)));
  return pose.length === 6 && pose.every(Number.isFinite) ? pose : null;
}

/** The text of an address as the value of a parameter; undefined where it makes no sense. */
export function valueFor(spec, text) {
  if (spec.kind.number) return Number.isFinite(Number(text)) && text.trim() !== "" ? Number(text) : undefined;
  if (spec.kind.choice) return spec.kind.choice.options.some(({ id }) => id === text) ? text : undefined;
  return { true: true, false: false }[text];
}

/** The address that brings a setting back, see `shareButton`. */
export function address({ sample, method, specs, values, opened, pose, field, look }) {
  const query = new URLSearchParams();
  if (sample) query.set("sample", sample);
  query.set("method", method);
  for (const { id } of specs) {
    // What was painted or brought along does not travel in a link.
    if (id === "init" && ["painted", "seeds", "file"].includes(values[id])) continue;
    // Samples have values of their own; who opens the link for a file may start from any.
    if (id in values && !(sample && values[id] === opened[id])) query.set(PREFIX + id, String(values[id]));
  }
  if (pose) query.set("view", pose.map((number) => Number(number.toFixed(DIGITS))).join(","));
  if (field && field !== "pieces") query.set("field", field);
  for (const [key, name] of Object.entries(look)) if (name) query.set(key, name);
  const url = new URL(location.href);
  url.hash = "";
  url.search = query;
  return url.href;
}

/** `state()` gives `{ sample, isChanged, name, method, specs, values, opened, pose, field, look }` of the document. */
export function shareButton(state) {
  const panel = byId("share-pop");
  const [title, field, note] = panel.children;
  popover(byId("share"), panel, {
    async opened() {
      const now = state();
      const link = address(now);
      const isLong = link.length > MOST_BYTES;
      field.hidden = isLong;
      if (isLong) {
        title.textContent = "Too much for a link";
        note.textContent = "So many settings make a link longer than mail and hosts let pass. Send the project instead: Export › Project (JSON).";
        return;
      }
      field.value = link;
      field.focus();
      field.setSelectionRange(0, field.value.length, "backward");
      title.textContent = "Link to this setting";
      note.textContent = now.sample
        ? `Whoever opens it sees the same sample with the same parameters${now.isChanged ? ", before repair and preparation" : ""}.`
        : `It holds the parameters only: ${now.name} never leaves this computer, so send the file too.`;
      try {
        await navigator.clipboard.writeText(field.value);
        title.textContent = "Link copied";
      } catch {
        title.textContent = "Copy this link";
      }
    },
  });
}
