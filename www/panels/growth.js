// How developable patches come about: pieces and seam after each stage, the one at work marked.

import { h, write } from "../dom.js";
import { count, measure } from "../format.js";

/** Gives a node that stands under the parameters of the first pieces. */
export function growthPanel() {
  const body = h("tbody");
  const node = h(
    "div",
    { class: "growth", hidden: true },
    h(
      "table",
      {},
      h("caption", { class: "sr" }, "Stages"),
      h("thead", {}, h("tr", {}, ...["Stage", "Pieces", "Seam"].map((name) => h("th", { scope: "col" }, name)))),
      body,
    ),
  );
  let rows = [];

  function build(stages) {
    rows = stages.map(({ label }) => {
      const [pieces, seam] = [h("td"), h("td")];
      const row = h("tr", {}, h("th", { scope: "row" }, label), pieces, seam);
      return { row, pieces, seam, label };
    });
    body.replaceChildren(...rows.map(({ row }) => row));
  }

  return {
    node,
    /** Takes a `patches` event. */
    show({ stages }) {
      if (stages.length !== rows.length || stages.some(({ label }, i) => label !== rows[i].label)) build(stages);
      stages.forEach(({ pieces, seam, is_active: isActive }, i) => {
        write(rows[i].pieces, pieces === null ? "–" : count(pieces));
        write(rows[i].seam, seam === null ? "–" : measure(seam, "√A"));
        if (isActive) rows[i].row.setAttribute("aria-current", "step");
        else rows[i].row.removeAttribute("aria-current");
      });
      node.hidden = stages.length === 0;
    },
    clear() {
      node.hidden = true;
    },
  };
}
