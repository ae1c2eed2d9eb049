// Links that bring a setting back: the sample, the method and every parameter that opening it would not set.

import { byId, popover } from "../dom.js";

const PREFIX = "p.";

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
  };
}

/** The text of an address as the value of a parameter; undefined where it makes no sense. */
export function valueFor(spec, text) {
  if (spec.kind.number) return Number.isFinite(Number(text)) && text.trim() !== "" ? Number(text) : undefined;
  if (spec.kind.choice) return spec.kind.choice.options.some(({ id }) => id === text) ? text : undefined;
  return { true: true, false: false }[text];
}

function address({ sample, method, specs, values, opened }) {
  const query = new URLSearchParams();
  if (sample) query.set("sample", sample);
  query.set("method", method);
  for (const { id } of specs) {
    // What was painted or brought along does not travel in a link.
    if (id === "init" && ["painted", "seeds", "file"].includes(values[id])) continue;
    // Samples have values of their own; who opens the link for a file may start from any.
    if (id in values && !(sample && values[id] === opened[id])) query.set(PREFIX + id, String(values[id]));
  }
  const url = new URL(location.href);
  url.hash = "";
  url.search = query;
  return url.href;
}

/** `state()` gives `{ sample, isChanged, name, method, specs, values, opened }` of the document. */
export function shareButton(state) {
  const panel = byId("share-pop");
  const [title, field, note] = panel.children;
  popover(byId("share"), panel, {
    async opened() {
      const now = state();
      field.value = address(now);
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
