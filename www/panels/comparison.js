// The optimum beside other ways to place cones, in numbers.

import { h } from "../dom.js";
import { count, fixed, pi } from "../format.js";

const LINES = [
  ["Cones", (row) => count(row.count)],
  ["Total angle", (row) => pi(row.total_angle)],
  ["∫u²", (row) => number(row.int_u2, 4)],
  ["RMS u", (row) => number(row.rms_u, 3)],
  ["Largest |u|", (row) => number(row.max_abs_u, 3)],
  ["Angle distortion", (row) => number(row.chart_angle, 3)],
  ["Area distortion", (row) => number(row.chart_area, 3)],
];

const number = (value, decimals) => (value === null || value === undefined ? "–" : fixed(value, decimals));

/** A table of one column for each way, in `host`; hidden until there is something to compare. */
export function comparisonPanel(host) {
  const head = h("thead");
  const body = h("tbody");
  const node = h("table", { class: "comparison", tabindex: "-1", hidden: true }, h("caption", { class: "sr" }, "Comparison"), head, body);
  host.append(node);
  return {
    /** Takes a `cone_comparison` event. */
    show({ rows }) {
      node.hidden = rows.length === 0;
      if (node.hidden) return;
      head.replaceChildren(h("tr", {}, h("th", { scope: "col" }, "Comparison"), ...rows.map(({ label }) => h("th", { scope: "col" }, label))));
      body.replaceChildren(
        ...LINES.map(([label, text]) => h("tr", {}, h("th", { scope: "row" }, label), ...rows.map((row) => h("td", {}, text(row))))),
      );
    },
    reveal() {
      if (node.hidden) return;
      node.scrollIntoView({ block: "nearest" });
      node.focus({ preventScroll: true });
    },
    hide: () => (node.hidden = true),
  };
}
