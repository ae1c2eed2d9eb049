// The distortion that is left against the angle that is spent, along the whole path over λ, with rivals of the optimum.

import { s } from "../dom.js";
import { count, dial, fixed, pi, plural, tick, ticks } from "../format.js";
import { labeller } from "./labeller.js";

const [LEFT, RIGHT, TOP, BOTTOM] = [44, 40, 12, 22];
/** Between two counts along the curve, in pixels. */
const SPARSE = 64;

/** What stands in a drawing of that size, and its text. `points` are optima, `now` the present one or null, `rivals` other ways. */
export function overAngle({ points, now, rivals, width, height }) {
  const all = [...points, ...rivals, ...(now ? [now] : [])];
  const angles = all.map((point) => point.total_angle / Math.PI);
  const [low, high] = [Math.min(...angles), Math.max(...angles)];
  const room = Math.max((high - low) * 0.04, high * 0.02, 1e-6);
  const [start, end] = [Math.max(0, low - room), high + room];
  const top = Math.max(...all.map((point) => point.int_u2), 1e-12);
  const floor = height - BOTTOM;
  const yTicks = ticks(top, Math.max(2, Math.min(4, Math.floor(height / 40))));
  const ceiling = Math.max(top, yTicks.at(-1));
  const x = (point) => LEFT + ((width - RIGHT - LEFT) * (point.total_angle / Math.PI - start)) / (end - start);
  const y = (point) => floor - ((floor - TOP) * point.int_u2) / ceiling;

  const nodes = yTicks.flatMap((value) => {
    const at = Math.round(y({ int_u2: value })) + 0.5;
    return [s("path", { class: "grid", d: `M${LEFT} ${at}H${width}` }), s("text", { class: "ax", x: LEFT - 6, y: at + 4, "text-anchor": "end" }, tick(value))];
  });
  const step = ticks(end - start, Math.max(2, Math.floor(width / 90)))[1] ?? 1;
  for (let value = Math.ceil(start / step) * step; value <= end; value += step) {
    nodes.push(s("text", { class: "ax", x: x({ total_angle: value * Math.PI }), y: height - 4, "text-anchor": "middle" }, `${tick(Number(value.toPrecision(6)))}\u202fπ`));
  }
  if (points.length > 1) {
    nodes.push(s("path", { class: "first", d: `M${points.map((point) => `${x(point).toFixed(1)} ${y(point).toFixed(1)}`).join("L")}` }));
  }
  const label = labeller(nodes, LEFT, width, floor);
  if (now) {
    nodes.push(s("circle", { class: "here", cx: x(now), cy: y(now), r: 4 }));
    label(x(now), y(now), now.isPlaced ? `Best places, ${count(now.count)}` : `${plural(now.raw, "vertex", "vertices")}, λ ${dial(now.lambda)}`, "strong");
  }
  for (const rival of rivals) {
    nodes.push(s("circle", { class: "second", cx: x(rival), cy: y(rival), r: 3.5 }));
    label(x(rival), y(rival), `${rival.label.split(",")[0]}, ${count(rival.count)}`, "second");
  }
  let last = null;
  for (const point of points) {
    if (last && Math.hypot(x(point) - x(last), y(point) - y(last)) < SPARSE) continue;
    if (last && last.count === point.count) continue;
    last = point;
    nodes.push(s("circle", { class: "first", cx: x(point), cy: y(point), r: 2.2 }));
    label(x(point), y(point), count(point.count), "small");
  }
  const here = now ? `: ${plural(now.count, "cone")} with ${pi(now.total_angle)} in all leave ∫u² = ${fixed(now.int_u2, 4)}` : "";
  return { nodes, label: `Distortion against total angle${here}` };
}
