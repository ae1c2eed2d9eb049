// The page as a guest in another: both views, the run and the stages of the method, and a way to the whole page.

import { h } from "../dom.js";

/** Arranges the page for a small frame. `link()` gives the address of what is shown now, without the frame. */
export function embed(link) {
  document.documentElement.dataset.embed = "";
  const anchor = h("a", { class: "link whole", target: "_blank", rel: "noopener", href: link(), title: "Opens the whole page in another tab" }, "Open in Cutflow");
  // What is shown may have changed since.
  for (const event of ["pointerdown", "focus"]) anchor.addEventListener(event, () => (anchor.href = link()));
  document.querySelector(".transport").append(anchor);
}
