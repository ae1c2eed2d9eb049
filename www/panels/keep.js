// The offer to keep the cut when a mesh takes the place of another one.

import { h, icon } from "../dom.js";

/** @param keep puts the cut of the mesh before on the one that is open */
export function keepCut(keep) {
  let strip = null;
  function end() {
    strip?.remove();
    strip = null;
  }
  return {
    end,
    /** Offers the cut of the mesh of this name. */
    offer(name) {
      end();
      const take = () => {
        end();
        keep();
      };
      strip = h(
        "div",
        { class: "restore", role: "group", "aria-label": "Cut of the mesh before" },
        h("p", {}, "This mesh starts with a new cut. Keep the one of ", h("b", {}, name), "?"),
        h("button", { class: "btn primary", onclick: take }, "Keep the cut"),
        h("button", { class: "icon", "aria-label": "Start with the new cut", title: "Start with the new cut", onclick: end }, icon("close")),
      );
      document.querySelector(".notices").append(strip);
    },
  };
}
