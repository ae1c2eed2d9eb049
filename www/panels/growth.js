// How developable patches come about: pieces and seam after each stage, the one at work marked.

import { h, write } from "../dom.js";
import { count, measure } from "../format.js";

/**
 * Gives a node that stands under the parameters of the first pieces.
 *
 * @param on `sew(patches, joins)` says what is to become of two pieces, `handOver()` goes on with the cut flow
 */
export function growthPanel(on) {
  const body = h("tbody");
  const number = (label, value) => h("input", { type: "number", min: 1, step: 1, value, "aria-label": label });
  const [first, second] = [number("First piece", 1), number("Second piece", 2)];
  const join = h("button", { class: "act", title: "These two become one, whatever the limits say, if it can be laid flat", onclick: () => sew(true) }, "Join");
  const part = h("button", { class: "act", title: "These two never become one", onclick: () => sew(false) }, "Keep apart");
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
    h("div", { class: "sew", role: "group", "aria-label": "Two pieces" }, h("span", {}, "Pieces ", first, " and ", second), h("span", {}, join, part)),
    h("button", { class: "act", title: "Starts the cut flow from these pieces: it moves their borders to lower the distortion", onclick: on.handOver }, "Improve by the cut flow"),
  );
  let rows = [];

  function sew(joins) {
    const patches = [first, second].map(({ value }) => Number(value) - 1);
    on.sew(patches, joins);
  }

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
      const { pieces, is_active: isActive } = stages.at(-1) ?? {};
      // There are two pieces to choose once merging is over, if it has left two.
      for (const control of [first, second, join, part]) control.disabled = isActive || !(pieces > 1);
      for (const input of [first, second]) input.max = Math.max(1, pieces ?? 1);
      node.hidden = stages.length === 0;
    },
    clear() {
      node.hidden = true;
    },
  };
}
