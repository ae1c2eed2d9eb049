// The path over λ: how many cones each price leaves. It stands above the slider of λ and has its scale, so that dot
// and handle are one line.

import { h, paced, s, write } from "../dom.js";
import { count, decades, dial, plural, power } from "../format.js";
import { NOTCHES, scale } from "./number.js";

const INTERVAL = 60;
const HEIGHT = 92;
const TOP = 10;
const FLOOR = HEIGHT - 16;
/** Half of a slider's handle, whose middle moves between these distances from the ends. */
const HANDLE = 6;

/** Pixels of a letter of the label. */
const LETTER = 6.6;
/** Between the top and a line of text that stands clear of the button. */
const CLEAR = 38;

/** The place of a count: the root shows few beside many. */
const rise = (n, most) => FLOOR - ((FLOOR - TOP) * Math.sqrt(n)) / Math.sqrt(Math.max(1, most));

/** What is said of so many optimal cones of which so many are in use: neighbours are merged, others set by hand. */
function wordings(raw, used) {
  const whole = plural(raw, "cone");
  if (used === raw) return [whole];
  return used < raw ? [`${whole}, merged to ${count(used)}`, whole] : [`${plural(used, "cone")} in use`];
}

/** `on.trace()` and `on.stop()` begin and end the computation, `on.clear()` drops edits, `on.lambda(value)` sets λ. */
export function pathPanel(on) {
  let points = [];
  let isComplete = false;
  let now = null;
  let range = null;
  let width = 0;
  let isTracing = false;
  const svg = s("svg", { role: "img", "aria-label": "Number of cones over λ" });
  const bar = h("progress", { max: 1, "aria-label": "Tracing the path" });
  const stop = h("button", { type: "button", class: "act", onclick: on.stop }, "Stop");
  const work = h("div", { class: "tracing", hidden: true }, bar, stop);
  const trace = h("button", { type: "button", class: "act", hidden: true, title: "Solve for every λ once: then the whole path is seen, and found again at once", onclick: on.trace }, "Trace path");
  const over = h("div", { class: "over" }, work, trace);
  const edited = h(
    "p",
    { class: "edited", hidden: true },
    h("span", { class: "fine" }, "Edited by hand"),
    h("button", { type: "button", class: "act", onclick: on.clear, title: "Drops all edits: the optimum chooses places and angles again" }, "Drop edits"),
  );
  const note = h("p", { class: "fine", hidden: true });
  const node = h("div", { class: "path", hidden: true }, h("div", { class: "pathplot" }, svg, over));
  const plot = node.firstElementChild;
  // Below the sliders, which are not to move away under a hand.
  const foot = h("div", { class: "pathfoot", hidden: true }, note, edited);
  new ResizeObserver(([{ contentRect }]) => {
    width = contentRect.width;
    redraw();
  }).observe(node);

  const place = (lambda) => HANDLE + ((width - 2 * HANDLE) * range.toNotch(lambda)) / NOTCHES;

  // A press on the plot is a press on the slider below it.
  const setFrom = (event) => {
    if (!range || width < 40) return;
    const at = (event.clientX - svg.getBoundingClientRect().left - HANDLE) / (width - 2 * HANDLE);
    on.lambda(range.fromNotch(NOTCHES * Math.min(1, Math.max(0, at))));
  };
  svg.addEventListener("pointerdown", (event) => {
    if (event.button > 0) return;
    svg.setPointerCapture(event.pointerId);
    setFrom(event);
  });
  svg.addEventListener("pointermove", (event) => svg.hasPointerCapture(event.pointerId) && setFrom(event));

  function stairs(most) {
    const at = (point) => [place(point.lambda).toFixed(1), rise(point.count, most).toFixed(1)];
    const [, top] = at(points[0]);
    let path = `M${width} ${top}`;
    let [left, height] = [width, top];
    for (const point of points) {
      const [x, y] = at(point);
      // Between two samples nothing is known: the step is drawn where the lower price was seen.
      path += `H${x}`;
      if (y !== height) path += `V${y}`;
      [left, height] = [x, y];
    }
    return { line: path, area: `${path}V${FLOOR}H${width}Z`, left };
  }

  /** The text of the dot at x, y: the longer one where there is room, to the right before all, where the curve lies lower. */
  function labelAt(x, y, texts, most, hasButton) {
    const fits = texts.flatMap((text) => [[text, x + 8], [text, x - 8 - LETTER * text.length]]);
    const [text, start] = fits.find(([text, start]) => start >= 0 && start + LETTER * text.length <= width) ?? fits.at(-1);
    const end = start + LETTER * text.length;
    const least = hasButton && end > over.offsetLeft ? CLEAR : 12;
    // To the left the curve rises: the label stands below it, or above all of it near the floor.
    const highest = Math.min(y, ...points.filter((point) => start <= place(point.lambda) && place(point.lambda) <= x).map((point) => rise(point.count, most)));
    const wanted = start > x || points.length === 0 ? y - 7 : y + 17 < FLOOR ? y + 17 : highest - 5;
    return { text, start, end, y: Math.max(least, Math.min(wanted, FLOOR - 4)) };
  }

  const redraw = paced(INTERVAL, () => {
    node.hidden = !range;
    foot.hidden ||= !range;
    if (!range || width < 40) return;
    const { min, max } = range;
    work.hidden = !isTracing;
    const reached = points.length > 0 ? Math.log(points[0].lambda / points.at(-1).lambda) / Math.log(points[0].lambda / min) : 0;
    if (Number.isFinite(reached)) bar.value = Math.min(1, Math.max(0, reached));
    const hadFocus = document.activeElement === trace || document.activeElement === stop || document.activeElement === document.body;
    trace.hidden = isTracing || isComplete || !now;
    write(trace, points.length > 1 ? "Trace the rest" : "Trace path");
    if (hadFocus && document.activeElement === document.body && wasPressed) (isTracing ? stop : trace).focus({ preventScroll: true });

    svg.setAttribute("viewBox", `0 0 ${width} ${HEIGHT}`);
    // An exact number of cones is on no path.
    const at = now?.is_placed ? null : now;
    plot.hidden = Boolean(now?.is_placed) && points.length === 0;
    const shown = at?.raw_count ?? at?.cones.length ?? 0;
    // Alone the point stands in the middle: nothing is known of the numbers beside it.
    const most = Math.max(1, points.length > 0 ? shown : 4 * shown, ...points.map((point) => point.count));
    const hasButton = !(trace.hidden && work.hidden);
    const nodes = [];
    const marks = [];
    for (const tick of [10, 100, 1000, 10_000].filter((tick) => tick < 0.9 * most && most < 120 * tick)) {
      const y = Math.round(rise(tick, most)) + 0.5;
      nodes.push(s("path", { class: "grid", d: `M0 ${y}H${width}` }));
      marks.push({ y: y - 3, text: count(tick) });
    }
    nodes.push(s("path", { class: "grid", d: `M0 ${FLOOR + 0.5}H${width}` }));
    if (points.length > 0) {
      const { line, area } = stairs(most);
      nodes.push(s("path", { class: "area", d: area }), s("path", { class: "line", d: line }));
    }
    for (const tick of decades(min, max)) {
      const x = place(tick);
      const anchor = x < 16 ? "start" : x > width - 24 ? "end" : "middle";
      nodes.push(s("text", { class: "ax", x: anchor === "start" ? 0 : anchor === "end" ? width : x, y: HEIGHT - 2, "text-anchor": anchor }, power(tick)));
    }
    const label = at && labelAt(place(at.lambda), rise(shown, most), wordings(shown, at.cones.length), most, hasButton);
    if (at) {
      const [x, y] = [place(at.lambda), rise(shown, most)];
      nodes.push(s("path", { class: "now", d: `M${x.toFixed(1)} ${TOP - 6}V${FLOOR}` }), s("circle", { class: "now", cx: x, cy: y, r: 4 }));
    }
    // Numbers stand over the curve, at the end that is free: on the left, which is traced last, while the button has the right one.
    for (const { y, text } of marks) {
      const start = hasButton ? 0 : width - LETTER * text.length;
      const isUnder = label && Math.abs(label.y - y) < 14 && label.start < start + LETTER * text.length && start < label.end;
      if (!isUnder) nodes.push(s("text", { class: "ax", x: hasButton ? 0 : width, y, "text-anchor": hasButton ? "start" : "end" }, text));
    }
    if (label) nodes.push(s("text", { class: "label", x: label.start, y: label.y }, label.text));
    svg.replaceChildren(...nodes);
    const path = points.length > 0 ? `, from ${count(points[0].count)} at ${dial(points[0].lambda)} to ${count(points.at(-1).count)} at ${dial(points.at(-1).lambda)}` : "";
    svg.setAttribute("aria-label", `Number of cones over λ${path}${at ? `; ${plural(shown, "cone")} at λ ${dial(at.lambda)}` : ""}`);
    edited.hidden = !(now?.is_edited || now?.has_placed);
    note.hidden = !now?.note;
    write(note, now?.note ?? "");
    foot.hidden = edited.hidden && note.hidden;
  });
  /** Whether the keyboard or the pointer began what goes on: the focus stays with the two buttons. */
  let wasPressed = false;
  for (const button of [trace, stop]) button.addEventListener("click", () => (wasPressed = true));

  return {
    node,
    foot,
    /** Takes the spec of λ, undefined where the method has none. */
    spec(spec) {
      const bounds = spec?.kind.number;
      range = bounds ? { ...scale(bounds), min: bounds.min > 0 ? bounds.min : bounds.step, max: bounds.max } : null;
      if (!range) foot.hidden = true;
      redraw();
    },
    /** Takes a `cones` event. */
    show(event) {
      now = event;
      redraw();
    },
    /** Takes a `cone_path` event. */
    path(event) {
      points = event.points;
      isComplete = event.is_complete;
      redraw();
    },
    tracing(isOn) {
      isTracing = isOn;
      if (!isOn) wasPressed = false;
      redraw();
    },
    points: () => points,
    clear() {
      [points, isComplete, now] = [[], false, null];
      redraw();
    },
  };
}
