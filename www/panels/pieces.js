// The Pieces table: one row a piece, linked with the views by hovering and by focus.

import { h, icon, paced, write } from "../dom.js";
import { count, measure, percent, short } from "../format.js";

const INTERVAL = 125;

/**
 * `hover(patch)` is called with the piece under the pointer or the focus, -1 for none; `fly(patch)` on Enter and double click, `isolate(patch)` on I.
 */
export function piecesPanel(host, hover, { fly, isolate }) {
  let pieces = [];
  let lit = -1;
  const body = h("tbody");
  const lines = [];
  const isNarrow = matchMedia("(max-width: 820px)");
  host.append(
    h(
      "table",
      {},
      h("caption", { class: "sr" }, "Pieces"),
      h("thead", {}, h("tr", {}, ...["Pieces", "Area", "Seam", "RMS u"].map((name) => h("th", { scope: "col" }, name)))),
      body,
    ),
  );

  function line(i) {
    while (lines.length <= i) {
      const n = lines.length;
      const chip = h("i", { class: "chip" });
      const warning = h("span", { class: "warning", role: "img", hidden: true }, icon("alert"));
      const [area, seam, u] = [h("td"), h("td"), h("td")];
      const [bar, value] = [h("i", { class: "bar" }), h("span")];
      u.append(bar, value);
      const head = h("th", { scope: "row" }, chip, h("span", {}, count(n + 1)), warning);
      const row = h(
        "tr",
        {
          // One stop of the Tab key for the whole table; arrows go from row to row.
          tabindex: n === 0 ? "0" : "-1",
          "aria-keyshortcuts": "Enter I",
          onpointerenter: () => hover(n),
          onpointerleave: () => hover(-1),
          ondblclick: () => fly(n),
          onfocus: () => hover(n),
          onblur: () => hover(-1),
          onkeydown: (event) => press(event, n),
        },
        head,
        area,
        seam,
        u,
      );
      lines.push({ row, chip, warning, area, seam, bar, value });
    }
    return lines[i];
  }

  function press(event, n) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const to = { ArrowDown: n + 1, ArrowUp: n - 1, Home: 0, End: pieces.length - 1 }[event.key];
    if (to !== undefined) {
      const { row } = lines[Math.min(Math.max(to, 0), pieces.length - 1)];
      for (const { row: other } of lines) other.tabIndex = other === row ? 0 : -1;
      row.focus();
    } else if (event.key === "Enter") fly(n);
    else if (event.key === "i" || event.key === "I") isolate(n);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  const redraw = paced(INTERVAL, () => {
    const largest = Math.max(...pieces.map((piece) => piece.rms_u ?? 0), 1e-12);
    pieces.forEach((piece, i) => {
      const { chip, warning, area, seam, bar, value } = line(i);
      chip.className = `chip c${piece.color}`;
      const note = piece.note || (piece.has_chart ? "" : "Not flattened yet");
      warning.hidden = !note;
      warning.title = note;
      warning.setAttribute("aria-label", note);
      write(area, percent(piece.area_fraction));
      write(seam, measure(piece.seam_length, "√A"));
      write(value, piece.rms_u === null || piece.rms_u === undefined ? "–" : short(piece.rms_u));
      bar.style.setProperty("--w", (piece.rms_u ?? 0) / largest);
    });
    if (body.childElementCount !== pieces.length) {
      body.replaceChildren(...lines.slice(0, pieces.length).map(({ row }) => row));
      // The stop of the Tab key may have been in a row that is gone.
      if (lines.length > 0 && !body.querySelector("[tabindex='0']")) lines[0].row.tabIndex = 0;
    }
  });

  return {
    show(list) {
      pieces = list;
      redraw();
    },
    /** The measures of a piece, if there are any yet. */
    piece: (patch) => pieces[patch],
    /** Lights the row of a piece; `reveal` brings it into sight. */
    light(patch, reveal) {
      lines[lit]?.row.classList.remove("on");
      lit = patch;
      const row = lines[patch]?.row;
      if (!row) return;
      row.classList.add("on");
      if (!reveal || isNarrow.matches || !row.isConnected) return;
      // Scrolls the table only, never the page.
      const head = host.querySelector("thead").offsetHeight;
      if (row.offsetTop < host.scrollTop + head) host.scrollTop = row.offsetTop - head;
      else if (row.offsetTop + row.offsetHeight > host.scrollTop + host.clientHeight) {
        host.scrollTop = row.offsetTop + row.offsetHeight - host.clientHeight;
      }
    },
  };
}
