// The lines between parameters, views and dock can be dragged, and moved by the keyboard. They stay where they were put,
// as far as the window lets them: no pane is ever squeezed out of sight.

import { byId, h } from "../dom.js";
import { recall, remember } from "../storage.js";

/** The name of the places in the storage. */
const KEY = "layout";
/** Pixels of a press of an arrow key, and with Shift. */
const STEP = 16;
const LEAP = 64;
/** The least that panes keep: what is in them can still be worked with. */
const LEAST = { panel: 240, view: 280, dock: 132, height: 200 };
const MOST_PANEL = 640;
/** Top bar and tabs. */
const BARS = 84;

const clamp = (value, [least, most]) => Math.min(Math.max(value, least), Math.max(least, most));

/** Puts the three lines into the page. */
export function splitters() {
  const root = document.documentElement;
  const [panel, dock] = [byId("parameters"), document.querySelector(".dock")];
  const [surface, flat] = [document.querySelector(".view.surface"), document.querySelector(".view.flat")];
  const places = read();
  const width = (node) => node.getBoundingClientRect().width;
  const height = (node) => node.getBoundingClientRect().height;

  /**
   * By name: the panes on both sides, what `now()` is, the `range()` it may have, and how it is shown. Sizes are pixels, of
   * the views the surface's share in them.
   */
  const lines = {
    panel: {
      label: "Width of the parameters",
      sides: [panel, surface],
      now: () => width(panel),
      range: () => [LEAST.panel, Math.min(MOST_PANEL, document.body.clientWidth - 2 * LEAST.view)],
      apply: (size) => set("--panel", size && `${size}px`),
      toward: (x) => x,
      text: (size) => `${Math.round(size)} pixels`,
    },
    views: {
      label: "Width of the surface view",
      sides: [surface, flat],
      now: () => width(surface) / bothViews(),
      range: () => [LEAST.view / bothViews(), 1 - LEAST.view / bothViews()],
      apply(share) {
        set("--surface", share && `${share.toFixed(4)}fr`);
        set("--flat", share && `${(1 - share).toFixed(4)}fr`);
      },
      toward: (x) => x / bothViews(),
      text: (share) => `${Math.round(100 * share)} percent`,
    },
    dock: {
      label: "Height of the plots and tables",
      sides: [surface, dock],
      isFlat: true,
      now: () => height(dock),
      range: () => [LEAST.dock, document.body.clientHeight - BARS - LEAST.height],
      apply: (size) => set("--dock", size && `${size}px`),
      toward: (y) => -y,
      text: (size) => `${Math.round(size)} pixels`,
    },
  };
  const bothViews = () => Math.max(1, width(surface) + width(flat));
  const set = (name, value) => (value ? root.style.setProperty(name, value) : root.style.removeProperty(name));

  function keep() {
    const isEmpty = Object.keys(places).length === 0;
    remember(KEY, isEmpty ? null : JSON.stringify(places));
  }

  /** Applies what was asked for as far as there is room; what was asked for is remembered for a larger window. */
  function layOut() {
    for (const [name, line] of Object.entries(lines)) {
      line.apply(name in places ? clamp(places[name], line.range()) : null);
    }
    for (const line of Object.values(lines)) tell(line);
  }

  function tell({ node, sides, now, range, text }) {
    // Learn and small screens arrange the panes in another way.
    node.hidden = sides.some((pane) => pane.getClientRects().length === 0);
    if (node.hidden) return;
    // A share counts in hundredths for who hears it.
    const scale = node === lines.views.node ? 100 : 1;
    const [least, most] = range();
    for (const [key, value] of [["valuenow", now()], ["valuemin", least], ["valuemax", Math.max(least, most)]]) {
      node.setAttribute(`aria-${key}`, String(Math.round(scale * value)));
    }
    node.setAttribute("aria-valuetext", text(now()));
  }

  function put(name, value) {
    if (value === null) delete places[name];
    else places[name] = clamp(value, lines[name].range());
    layOut();
  }

  for (const [name, line] of Object.entries(lines)) {
    const { label, sides, isFlat, toward } = line;
    const node = h("div", {
      class: `split split-${name}`,
      role: "separator",
      tabindex: "0",
      "aria-label": label,
      "aria-orientation": isFlat ? "horizontal" : "vertical",
      "aria-controls": sides.map(({ id }) => id).filter(Boolean).join(" ") || null,
      title: "Drag or arrow keys move it, double click or Enter puts it back",
    });
    line.node = node;
    sides[1].before(node);
    const at = (event) => (isFlat ? event.clientY : event.clientX);
    let drag = null;
    node.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      node.setPointerCapture(event.pointerId);
      drag = { from: at(event), value: line.now() };
    });
    node.addEventListener("pointermove", (event) => {
      // A press that does not move is half a double click and puts nothing anywhere.
      if (drag && at(event) !== drag.from) put(name, drag.value + toward(at(event) - drag.from));
    });
    for (const end of ["pointerup", "pointercancel"]) {
      node.addEventListener(end, () => {
        drag = null;
        keep();
      });
    }
    const reset = () => {
      put(name, null);
      keep();
    };
    node.addEventListener("dblclick", reset);
    node.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const step = event.shiftKey ? LEAP : STEP;
      const [back, on] = isFlat ? ["ArrowUp", "ArrowDown"] : ["ArrowLeft", "ArrowRight"];
      const [least, most] = line.range();
      if (event.key === back) put(name, line.now() + toward(-step));
      else if (event.key === on) put(name, line.now() + toward(step));
      else if (event.key === "Home") put(name, least);
      else if (event.key === "End") put(name, most);
      else if (event.key === "Enter") put(name, null);
      else return;
      event.preventDefault();
      keep();
    });
  }

  const watch = new ResizeObserver(layOut);
  for (const node of [document.body, panel, surface, flat, dock]) watch.observe(node);
  layOut();
}

/** The places that were kept: numbers by name, whatever else the storage may hold. */
function read() {
  try {
    const kept = JSON.parse(recall(KEY) ?? "{}");
    return Object.fromEntries(["panel", "views", "dock"].filter((name) => Number.isFinite(kept?.[name])).map((name) => [name, kept[name]]));
  } catch {
    return {};
  }
}
