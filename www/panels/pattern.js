// The pattern workshop: what a trade asks of the pieces beside the sheet as it will be written. The picture is the very SVG of the
// export; the engine lays it out, the page only shows it.

import { byId, h, icon, roving, s, write } from "../dom.js";
import { fixed, parse, percent, plural } from "../format.js";
import { parametersPanel } from "./parameters.js";
import { sizePanel } from "./size.js";

/** The groups of parameters that belong here. */
export const PATTERN = "Pattern: ";
/** One step of the magnifier, and how far it goes. */
const ZOOM = 1.5;
const ZOOM_RANGE = [1, 40];

const WAITING = "Making the pattern …";

const mm = (length) => `${fixed(length, length < 10 ? 1 : 0)}\u00a0mm`;

/**
 * @param on `show(isShown)`, `change(id, value)`, `trade(id)`, `nest()`, `pause()`, `allowance(seam, mm)`, `save(kind)`; `setUnit(id)` and
 * `setSize(axis, value)` resolve when the engine has answered
 */
export function patternPanel(on) {
  const dialog = byId("pattern");
  const sheet = h("div", { class: "paper", tabindex: "0", role: "img", "aria-label": "Sheet of the pattern" });
  const picture = h("img", { alt: "", draggable: "false" });
  const pages = s("svg", { class: "pages", "aria-hidden": "true" });
  const board = h("div", { class: "board" }, picture, pages);
  sheet.append(board);
  const facts = h("p", { class: "facts", "aria-live": "polite" }, WAITING);
  const notices = h("ul", { class: "told", "aria-label": "Notices" });
  const pieces = h("tbody");
  const seams = h("tbody");
  const trades = h("div", { class: "chips", role: "group", "aria-label": "Trades" });
  roving(trades, "button");
  const settings = h("div");
  const size = sizePanel(on);
  const sizeHost = h("div", { class: "size" });
  const panel = parametersPanel(settings, on.change, {}, {}, (group) => group.startsWith(PATTERN), (group) => group.slice(PATTERN.length));
  const nest = h("button", { type: "button", class: "btn", title: "Looks for a layout that wastes less" }, icon("grid"), h("span", {}, "Improve layout"));
  const pageSwitch = h("button", { type: "button", class: "btn", "aria-pressed": "false", title: "Shows the pages of the PDF on the sheet" }, icon("layers"), h("span", {}, "Pages"));
  const zoomOut = h("button", { type: "button", class: "icon", "aria-label": "Smaller", title: "Smaller (−)" }, icon("minus"));
  const zoomIn = h("button", { type: "button", class: "icon", "aria-label": "Larger", title: "Larger (+)" }, icon("plus"));
  const zoomFit = h("button", { type: "button", class: "icon", "aria-label": "Whole sheet", title: "Whole sheet (0)" }, icon("fit"));
  const files = [["SVG", "Pattern (SVG)"], ["DXF", "Pattern (DXF)"], ["PDF", "Pattern (PDF)"], ["All files", "All files (ZIP)"]].map(([label, kind], i) =>
    h("button", { type: "button", class: i === 2 ? "btn primary" : "btn", title: `Save ${kind}`, onclick: () => on.save(kind) }, icon("export"), h("span", {}, label)),
  );
  let zoom = 1;
  let shown = null;
  let url = null;
  const wait = byId("wait");
  const waitHome = wait.parentElement;

  dialog.append(
    h("header", {}, h("h2", { id: "pattern-title" }, "Pattern"), h("span", { class: "grow" }), ...files,
      h("button", { type: "button", class: "icon", "aria-label": "Close", title: "Close (Esc)", onclick: () => close() }, icon("close"))),
    h("div", { class: "ask" }, h("fieldset", { class: "presets", "aria-label": "Trade" }, h("legend", {}, "For"), trades), sizeHost, settings),
    h("div", { class: "see" },
      h("div", { class: "over" }, facts, h("span", { class: "grow" }), nest, pageSwitch, zoomOut, zoomIn, zoomFit),
      sheet,
      h("div", { class: "lists" }, notices,
        table("Pieces", ["Piece", "Size", "Area", "Cut", "Stretch and bend"], pieces),
        table("Seams", ["Seam", "Sewn", "Length", "Ease", "Allowance"], seams))),
  );

  function table(name, heads, body) {
    return h("details", {}, h("summary", {}, name, icon("down")), h("table", {}, h("thead", {}, h("tr", {}, ...heads.map((head) => h("th", { scope: "col" }, head)))), body));
  }

  function setZoom(to) {
    zoom = Math.min(ZOOM_RANGE[1], Math.max(ZOOM_RANGE[0], to));
    const middle = [sheet.scrollLeft + sheet.clientWidth / 2, sheet.scrollTop + sheet.clientHeight / 2].map((at, i) => at / (i ? sheet.scrollHeight : sheet.scrollWidth));
    layOut();
    sheet.scrollTo(middle[0] * sheet.scrollWidth - sheet.clientWidth / 2, middle[1] * sheet.scrollHeight - sheet.clientHeight / 2);
    zoomOut.disabled = zoom <= ZOOM_RANGE[0];
  }

  /** Fits the sheet into the view, times the zoom. */
  function layOut() {
    if (!shown) return;
    const [width, height] = shown.report.sheet_mm;
    const room = [sheet.clientWidth - 32, sheet.clientHeight - 32];
    const scale = Math.max(0.01, Math.min(room[0] / width, room[1] / height)) * zoom;
    board.style.width = `${width * scale}px`;
    board.style.height = `${height * scale}px`;
  }

  function showPages() {
    const isOn = pageSwitch.getAttribute("aria-pressed") === "true";
    pages.replaceChildren();
    if (!shown || !isOn) return;
    const [width, height] = shown.report.sheet_mm;
    pages.setAttribute("viewBox", `0 0 ${width} ${height}`);
    for (const { name, frame: [x, y, w, tall] } of shown.pages) {
      // Within its page, and no larger than reads well where there are few.
      const letters = Math.min(Math.max(width, height) / 16, tall / 3, (1.4 * w) / Math.max(1, name.length));
      pages.append(
        s("rect", { x, y, width: w, height: tall, "vector-effect": "non-scaling-stroke" }),
        s("text", { x: x + w / 2, y: y + tall / 2, "font-size": letters }, name),
      );
    }
  }

  function showNotices(list) {
    notices.replaceChildren(...list.map((text) => h("li", {}, text)));
    notices.hidden = list.length === 0;
  }

  function seamRow(seam) {
    const ease = seam.flat_mm[0] - seam.flat_mm[1];
    const is = fixed(seam.allowance_mm, 1);
    const input = h("input", { "aria-label": `Allowance of seam ${seam.number}`, inputmode: "decimal", autocomplete: "off", value: is, "data-is": is });
    const commit = () => {
      const text = input.value.trim();
      const value = text === "" ? null : parse(text);
      if (value !== null && !(value >= 0)) input.value = input.dataset.is;
      else on.allowance(seam.number, value);
    };
    input.addEventListener("change", commit);
    const [first, second] = seam.pieces;
    return h("tr", {},
      h("th", { scope: "row" }, String(seam.number)),
      h("td", {}, first === second ? `${first} to itself` : `${first} to ${second}`),
      h("td", {}, mm(seam.length_mm)),
      h("td", {}, Math.abs(ease) < 0.05 ? "none" : `${fixed(ease, 1)}\u00a0mm`),
      h("td", { class: "own" }, input, " mm"));
  }

  /** Whoever stands in the table stays there: as long as the seams are the same, only what they say is written anew. */
  function showSeams(list) {
    const rows = list.map(seamRow);
    const at = document.activeElement;
    if (seams.contains(at) && rows.length === seams.childElementCount) {
      rows.forEach((row, i) => {
        const old = seams.children[i].querySelector("input");
        old.value = old.dataset.is = row.querySelector("input").value;
        for (const k of [1, 2, 3]) seams.children[i].children[k].replaceWith(row.children[k].cloneNode(true));
      });
    } else {
      seams.replaceChildren(...rows);
    }
  }

  function pieceRow({ name, size_mm: [width, height], area_mm2: area, copies: [plain, mirrored], hint }) {
    return h("tr", {},
      h("th", { scope: "row" }, name),
      h("td", {}, `${fixed(width, 0)} × ${fixed(height, 0)}\u00a0mm`),
      h("td", {}, `${fixed(area / 100, 1)}\u00a0cm²`),
      h("td", {}, mirrored > 0 ? `${plain} + ${mirrored} mirrored` : String(plain)),
      h("td", {}, hint));
  }

  zoomIn.addEventListener("click", () => setZoom(zoom * ZOOM));
  zoomOut.addEventListener("click", () => setZoom(zoom / ZOOM));
  zoomFit.addEventListener("click", () => setZoom(1));
  sheet.addEventListener("keydown", ({ key }) => {
    if (key === "+" || key === "=") setZoom(zoom * ZOOM);
    if (key === "-") setZoom(zoom / ZOOM);
    if (key === "0") setZoom(1);
  });
  sheet.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    setZoom(event.deltaY < 0 ? zoom * 1.2 : zoom / 1.2);
  }, { passive: false });
  pageSwitch.addEventListener("click", () => {
    pageSwitch.setAttribute("aria-pressed", String(pageSwitch.getAttribute("aria-pressed") !== "true"));
    showPages();
  });
  nest.addEventListener("click", () => (shown?.is_nesting ? on.pause() : on.nest()));
  new ResizeObserver(layOut).observe(sheet);
  function closed() {
    if (dialog.open || !size.node.isConnected) return;
    // The Mesh section has boxes of the same names.
    size.node.remove();
    waitHome.append(wait);
    on.show(false);
  }
  // A busy browser tells late of what it closed by itself.
  function close() {
    dialog.close();
    closed();
  }
  dialog.addEventListener("cancel", (event) => {
    event.preventDefault();
    close();
  });
  dialog.addEventListener("close", closed);

  return {
    open() {
      if (dialog.open) return;
      sizeHost.append(size.node);
      // Behind an open dialog nothing can be pressed: the strip with Cancel comes along.
      dialog.append(wait);
      dialog.showModal();
      setZoom(1);
      on.show(true);
    },
    close,
    isOpen: () => dialog.open,
    /** Takes a `size` event. */
    size: (event) => size.show(event),
    /** Takes a `parameters` event. */
    parameters: (event) => panel.show(event),
    /** Takes a `trades` event. */
    trades({ options, current }) {
      if (trades.childElementCount !== options.length) {
        trades.replaceChildren(...options.map(({ id, label, help }) =>
          h("button", { type: "button", "data-id": id, "aria-pressed": "false", title: help, onclick: () => on.trade(id) }, label)));
      }
      for (const button of trades.children) button.setAttribute("aria-pressed", String(button.dataset.id === current));
    },
    /** Takes a `pattern` event. */
    show(event) {
      const isFirst = shown === null;
      shown = event;
      const { report } = event;
      if (url) URL.revokeObjectURL(url);
      url = URL.createObjectURL(new Blob([event.svg], { type: "image/svg+xml" }));
      picture.src = url;
      const [width, height] = report.sheet_mm;
      const material = report.roll_length_mm > 0 ? `, ${mm(report.roll_length_mm)} of the roll` : report.sheets > 1 ? `, ${plural(report.sheets, "sheet")}` : "";
      write(facts, `${plural(report.pieces.length, "piece")} on ${fixed(width, 0)} × ${fixed(height, 0)}\u00a0mm${material}, ${percent(report.utilisation)} used, ${plural(event.pages.length, "page")}`);
      nest.querySelector("span").textContent = event.is_nesting ? "Stop" : "Improve layout";
      showNotices(report.notices);
      pieces.replaceChildren(...report.pieces.map(pieceRow));
      showSeams(report.seams);
      if (isFirst) setZoom(1);
      else layOut();
      showPages();
    },
    /** Takes an `error` event, which would be hidden behind. Gives whether it was shown. */
    refuse({ what, what_to_do }) {
      if (dialog.open) showNotices([`${what} ${what_to_do}`]);
      return dialog.open;
    },
    /** Forgets the sheet of another mesh. */
    clear() {
      shown = null;
      write(facts, WAITING);
      picture.removeAttribute("src");
      pages.replaceChildren();
    },
  };
}
