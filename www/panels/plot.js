// The energy over the steps: one line a term, each named at its right end, so that no key is needed.

import { h, paced, s } from "../dom.js";
import { count, fixed, short, tick, ticks, ticksBetween } from "../format.js";

const COLOURS = ["total", "first", "second", "third"];
/** Milliseconds between two drawings while a run goes on. */
const INTERVAL = 125;
/** Space for the numbers of the ticks: at least this much, and as wide as so many of their letters. */
const LEFT = 36;
const LETTER = 6.6;
const BOTTOM = 20;
const TOP = 8;
/** Space between the labels at the ends of the lines. */
const PITCH = 17;
/** What lies this many times above nearly all other steps is cut off: it would flatten the rest to a line. */
const SPIKE = 4;
const NEARLY_ALL = 0.9;

/** Keeps labels apart: pushes them down in order, then back up from the floor. */
function spread(wanted, floor) {
  const order = wanted.map((y, i) => i).sort((a, b) => wanted[a] - wanted[b]);
  const at = [...wanted];
  order.forEach((i, k) => {
    if (k > 0) at[i] = Math.max(at[i], at[order[k - 1]] + PITCH);
  });
  let limit = floor;
  for (const i of order.toReversed()) {
    at[i] = Math.min(at[i], limit);
    limit = at[i] - PITCH;
  }
  return at;
}

const topmost = (values) => values.reduce((most, value) => Math.max(most, value), -Infinity);

/** Up to where steps with these largest values are drawn. Both ends of the lines are always seen. */
function ceiling(peaks) {
  const most = topmost(peaks);
  const usual = peaks.toSorted((a, b) => a - b)[Math.floor(NEARLY_ALL * (peaks.length - 1))];
  return usual > 0 && most > SPIKE * usual ? Math.max(1.25 * usual, peaks[0], peaks.at(-1)) : most;
}

export function energyPlot(host) {
  let points = [];
  let size = { width: 0, height: 0 };
  let name = "Total J";
  const svg = s("svg", { role: "img", "aria-label": "Energy" });
  const hint = h("p", { class: "muted" }, "The energy of each step of a run appears here.");
  host.append(svg, hint);

  const redraw = paced(INTERVAL, draw);
  new ResizeObserver(([{ contentRect }]) => {
    size = contentRect;
    redraw();
  }).observe(host);

  function draw() {
    hint.hidden = points.length > 0;
    svg.toggleAttribute("hidden", points.length === 0);
    const { width, height } = size;
    if (points.length === 0 || width < 80 || height < 60) return;

    const last = points.at(-1);
    const names = [name, ...last.terms.map((term) => term.name)];
    const value = (point, line) => (line === 0 ? point.total : (point.terms[line - 1]?.value ?? 0));
    const labels = Math.min(154, width * 0.42);
    const right = width - labels;
    const floor = height - BOTTOM;
    // A reward may take the energy, or a term, below zero.
    const all = points.map((point) => [point.total, ...point.terms.map((term) => term.value)]);
    const base = all.reduce((low, values) => Math.min(low, ...values), 0);
    const peaks = all.map((values) => Math.max(0, ...values));
    const high = ceiling(peaks);
    const divisions = Math.min(5, Math.max(2, Math.floor(height / 36)));
    const yTicks = ticksBetween(base, Math.max(high, base + 1e-12), divisions);
    const top = Math.max(yTicks.at(-1), high, base + 1e-12);
    const left = Math.max(LEFT, 10 + LETTER * Math.max(...yTicks.map((mark) => tick(mark).length)));
    const x = (step) => left + ((right - left) * step) / Math.max(1, last.step);
    const y = (energy) => floor - ((floor - TOP) * (energy - base)) / (top - base);

    // All values with the decimals of the largest, so that they can be added up by eye.
    const largest = Math.max(...names.map((name, line) => Math.abs(value(last, line))));
    const digits = largest >= 1000 ? 0 : largest >= 100 ? 1 : largest >= 1 ? 2 : 4;

    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const nodes = yTicks.flatMap((mark) => [
      s("path", { class: "grid", d: `M${left} ${Math.round(y(mark)) + 0.5}H${right}` }),
      s("text", { class: "ax", x: left - 6, y: y(mark) + 4, "text-anchor": "end" }, tick(mark)),
    ]);
    for (const step of ticks(last.step, Math.max(2, Math.floor((right - left) / 70)), true)) {
      nodes.push(s("text", { class: "ax", x: x(step), y: height - 4, "text-anchor": "middle" }, count(step)));
    }
    // Two points a pixel are enough.
    const stride = Math.max(1, Math.floor(points.length / (2 * (right - left))));
    const drawn = points.filter((point, i) => i % stride === 0 || i === points.length - 1);
    const ends = spread(names.map((name, line) => y(value(last, line))), floor);
    for (let line = names.length - 1; line >= 0; line -= 1) {
      const colour = COLOURS[Math.min(line, COLOURS.length - 1)];
      const path = drawn.map((point) => `${x(point.step).toFixed(1)} ${y(value(point, line)).toFixed(1)}`).join("L");
      nodes.push(
        s("path", { class: colour, d: `M${path}` }),
        s("circle", { class: colour, cx: x(last.step), cy: y(value(last, line)), r: 2.5 }),
        s("text", { class: colour, x: right + 9, y: ends[line] + 4 }, names[line]),
        s("text", { class: "val", x: width, y: ends[line] + 4 }, fixed(value(last, line), digits)),
      );
    }
    const spike = peaks.indexOf(topmost(peaks));
    if (peaks[spike] > top) {
      const at = x(points[spike].step);
      const isRight = at < (left + right) / 2;
      nodes.push(s("text", { class: "ax cut", x: isRight ? at + 8 : at - 8, y: TOP + 6, "text-anchor": isRight ? "start" : "end" }, `↑ up to ${tick(peaks[spike])}`));
    }
    svg.replaceChildren(...nodes);
    const parts = last.terms.map((term) => `${term.name} ${short(term.value)}`).join(", ");
    svg.setAttribute("aria-label", `Energy ${short(last.total)} after ${count(last.step)} steps, of which ${parts}`);
  }

  return {
    /** Takes an `energy` event: step 0 begins a new plot, an earlier step cuts the plot back to it. */
    add(point) {
      points = points.filter(({ step }) => step < point.step && point.step > 0);
      points.push(point);
      redraw();
    },
    /** Takes what the sum of all terms is called. */
    call(text) {
      name = text;
      redraw();
    },
    /** Another mesh: its energies are yet to come. */
    clear() {
      points = [];
      redraw();
    },
    points: () => points,
  };
}
