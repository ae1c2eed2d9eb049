// The Measures table: what the cut and its pieces are worth now, beside what they were at the start.

import { h, icon, paced, write } from "../dom.js";
import { measure } from "../format.js";

const INTERVAL = 125;
/** Rows in which everything above zero is a fault. */
const FAULTS = ["flipped", "overlaps"];
/** What a row's number is, where its name does not say it. */
const TITLES = { area_distortion: "Root mean square of the log of the length ratio; half the log of the area ratio. 0.05 is about 10 % of the area" };

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
      const [warning, value] = [h("span", { class: "warning", role: "img", "aria-label": "Not safe to cut", hidden: true }, icon("alert")), h("span")];
      now.append(warning, value);
      cells.set(row.id, { head, now: value, warning, start, line: h("tr", { "data-id": row.id, title: TITLES[row.id] }, head, now, start) });
    }
    return cells.get(row.id);
  }

  const redraw = paced(INTERVAL, () => {
    const lines = rows.map((row) => {
      const { head, now, warning, start, line } = cellsFor(row);
      const isFault = FAULTS.includes(row.id) && row.now > 0;
      warning.hidden = !isFault;
      line.classList.toggle("fault", isFault);
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
    /** Brings rows into sight and marks them until the focus goes elsewhere. */
    reveal(ids) {
      const lines = ids.map((id) => cells.get(id)?.line).filter((line) => line?.isConnected);
      for (const line of lines) line.classList.add("on");
      host.addEventListener("blur", () => lines.forEach((line) => line.classList.remove("on")), { once: true });
      host.focus({ preventScroll: true });
      lines[0]?.scrollIntoView({ block: "center" });
    },
  };
}
