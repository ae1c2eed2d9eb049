// What the flattened view says when it has nothing to show, and the way on.

import { byId, h, icon } from "../dom.js";

/**
 * @param on `chooseMesh()` asks for a file, `openMesh()` opens the Mesh section, `repairAll()`, `toPieces()`, `cut()` makes the first cut, `solve()` runs
 * the method
 */
export function emptyState(on) {
  const host = byId("empty");
  const action = (label, run) => h("button", { class: "btn primary", onclick: run }, label);
  const states = {
    none: () => [
      h("p", {}, "No mesh is open: drop one here, or choose a sample."),
      action("Open a mesh", on.chooseMesh),
    ],
    blocked: (canRepair) => [
      icon("block"),
      h(
        "p",
        {},
        "Repair the mesh first: see ",
        h("button", { class: "link", onclick: on.openMesh }, "Mesh"),
        h("span", { class: "wide" }, " on the left"),
      ),
      canRepair ? action("Repair now", on.repairAll) : null,
    ],
    marked: () => [
      icon("eye"),
      h("p", {}, "A finding is marked on the surface."),
      h("button", { class: "btn outlined", onclick: on.toPieces }, "Back to the pieces"),
    ],
    uncut: () => [
      h("p", {}, "The mesh is not cut yet."),
      h("button", { class: "btn outlined", onclick: on.cut }, "Make the first cut"),
    ],
    undivided: () => [
      h("p", {}, "The surface is not divided yet."),
      h("button", { class: "btn outlined", onclick: on.solve }, "Divide it"),
    ],
    unsolved: () => [
      h("p", {}, "No cones yet: they show where the surface is cut."),
      h("button", { class: "btn outlined", onclick: on.solve }, "Place the cones"),
    ],
  };
  let shown = "";
  return {
    /** Takes the state's name, null for none, and whether a repair is on offer. */
    show(name, canRepair = false) {
      const print = `${name} ${canRepair}`;
      if (print === shown) return;
      shown = print;
      host.hidden = name === null;
      host.replaceChildren(...(name === null ? [] : states[name](canRepair).filter((node) => node !== null)));
    },
  };
}
