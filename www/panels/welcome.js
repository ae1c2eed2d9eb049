// The first visit: three sentences say what one sees, one gesture starts with a mesh of one's own. Once it was put away, or a
// mesh was opened, it does not come back.

import { byId, h, icon } from "../dom.js";
import { recall, remember } from "../storage.js";

const KEY = "welcomed";
/** Links that show something in particular need no welcome. */
const PARTICULAR = ["sample", "method", "embed"];

export function welcome() {
  const asked = new URLSearchParams(location.search);
  if (recall(KEY) !== null || PARTICULAR.some((name) => asked.has(name))) return;
  const file = byId("file");
  const over = new AbortController();
  const end = () => {
    card.remove();
    over.abort();
    remember(KEY, "yes");
  };
  const close = h("button", { type: "button", class: "icon", "aria-label": "Close welcome", title: "Do not show this again" }, icon("close"));
  close.addEventListener("click", () => {
    end();
    byId("parameters").querySelector("button, summary")?.focus();
  });
  const card = h(
    "aside",
    { class: "welcome", "aria-label": "Welcome" },
    h("h2", {}, "What you see"),
    close,
    h("p", {}, "A surface with a cut, and beside it the pieces laid flat, in matching colours. The cut moves step by step, so that the pieces flatten with less distortion and the cut stays short. Where the squares of the checkerboard stay square and of one size, a piece lies flat as it is."),
    h("p", {}, h("button", { type: "button", class: "btn", onclick: () => file.click() }, icon("open"), "Choose your mesh"), h("span", { class: "muted" }, "or drop it anywhere. Nothing is uploaded.")),
  );
  byId("parameters").prepend(card);
  file.addEventListener("change", end, { signal: over.signal });
  addEventListener("drop", ({ dataTransfer }) => dataTransfer?.files.length > 0 && end(), { signal: over.signal });
}
