// The Measures table: what the cut and its pieces are worth now, beside what they were at the start.

import { h, paced, write } from "../dom.js";
import { measure } from "../format.js";

const INTERVAL = 125;

export function measuresPanel(host) {
  let rows = [];
  const body = h("tbody");
  const cells = new Map();
  host.append(
    h(
      "table",
      {},
      h("caption", { class: "sr" }, "Measures"),
      h(
        "thead",
        {},
        h("tr", {}, h("th", { scope: "col" }, "Measures"), h("th", { scope: "col" }, "Now"), h("th", { scope: "col" }, "Start")),
      ),
      body,
    ),
  );

  function cellsFor(row) {
    if (!cells.has(row.id)) {
      const [head, now, start] = [h("th", { scope: "row" }), h("td"), h("td")];
      cells.set(row.id, { head, now, start, line: h("tr", { "data-id": row.id }, head, now, start) });
    }
    return cells.get(row.id);
  }

  const redraw = paced(INTERVAL, () => {
    const lines = rows.map((row) => {
      const { head, now, start, line } = cellsFor(row);
      write(head, row.label);
      write(now, measure(row.now, row.unit));
      write(start, measure(row.start, row.unit));
      return line;
    });
    if (lines.length !== body.childElementCount || lines.some((line, i) => body.children[i] !== line)) {
      body.replaceChildren(...lines);
    }
  });

  return {
    show(list) {
      rows = list;
      redraw();
    },
  };
}
