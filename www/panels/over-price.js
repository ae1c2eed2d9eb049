// Both sides of the bargain over λ: the distortion ∫u² that is left, and the total angle Φ that is spent for it.

import { s } from "../dom.js";
import { decades, dial, fixed, pi, power, rounds, tick, ticks } from "../format.js";
import { labeller } from "./labeller.js";

const [LEFT, RIGHT, TOP, BOTTOM] = [44, 40, 12, 22];

/** What stands in a drawing of that size, and its text. `points` are optima, `now` the present one or null. */
export function overPrice({ points, now, width, height }) {
  const all = [...points, ...(now ? [now] : [])];
  const prices = all.map(({ lambda }) => lambda);
  const [low, high] = [Math.min(...prices), Math.max(...prices)];
  const [floor, end] = [height - BOTTOM, width - RIGHT];
  const x = (lambda) => LEFT + ((end - LEFT) * Math.log(lambda / low)) / Math.max(Math.log(high / low), 1e-9);
  const parts = Math.max(2, Math.min(4, Math.floor(height / 40)));
  const nodes = [];
  const [distortion, angle] = [(point) => point.int_u2, (point) => point.total_angle / Math.PI].map((value) => {
    const top = Math.max(...all.map(value), 1e-12);
    const marks = ticks(top, parts);
    const ceiling = Math.max(top, marks.at(-1));
    return { value, marks, y: (number) => floor - ((floor - TOP) * number) / ceiling };
  });
  for (const mark of distortion.marks) {
    const at = Math.round(distortion.y(mark)) + 0.5;
    nodes.push(s("path", { class: "grid", d: `M${LEFT} ${at}H${end}` }), s("text", { class: "ax first", x: LEFT - 6, y: at + 4, "text-anchor": "end" }, tick(mark)));
  }
  for (const mark of angle.marks) {
    nodes.push(s("text", { class: "ax second", x: end + 6, y: Math.round(angle.y(mark)) + 4.5 }, `${tick(mark)}\u202fπ`));
  }
  // A short range may hold no power of ten.
  for (const value of high / low > 30 ? decades(low, high) : rounds(low, high)) {
    nodes.push(s("text", { class: "ax", x: x(value), y: height - 4, "text-anchor": "middle" }, power(value)));
  }
  nodes.push(s("text", { class: "ax", x: end + 6, y: height - 4 }, "λ"));
  const lines = [[distortion, "first"], [angle, "second"]];
  for (const [{ value, y }, kind] of lines) {
    const places = points.map((point) => `${x(point.lambda).toFixed(1)} ${y(value(point)).toFixed(1)}`);
    if (places.length > 1) nodes.push(s("path", { class: kind, d: `M${places.join("L")}` }));
  }
  if (now) nodes.push(s("path", { class: "at", d: `M${x(now.lambda).toFixed(1)} ${TOP - 6}V${floor}` }));
  const label = labeller(nodes, LEFT, end, floor);
  const shown = now ?? points[0];
  const texts = [`∫u² ${fixed(shown.int_u2, 4)}`, `total angle ${pi(shown.total_angle)}`];
  lines.forEach(([{ value, y }, kind], i) => {
    const [left, up] = [x(shown.lambda), y(value(shown))];
    nodes.push(s("circle", { class: kind, cx: left, cy: up, r: 3.5 }));
    // The distortion rises with λ: below its point there is room.
    label(left, up + (kind === "first" ? 12 : 0), texts[i], kind);
  });
  return { nodes, label: `Distortion and total angle over λ: at λ ${dial(shown.lambda)} ${texts.join(", ")}` };
}
