// What cones buy: the distortion that is left against the angle that is spent, along the whole path over λ.

import { paced, s, h } from "../dom.js";
import { count, dial, fixed, pi, plural, short, ticks } from "../format.js";

const INTERVAL = 100;
const [LEFT, RIGHT, TOP, BOTTOM] = [44, 40, 12, 22];
/** Between two counts along the curve, in pixels. */
const SPARSE = 64;

const tick = (value) => {
  const text = short(value);
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
};

export function distortionPlot(host) {
  let points = [];
  let now = null;
  let rivals = [];
  let size = { width: 0, height: 0 };
  const svg = s("svg", { role: "img", "aria-label": "Distortion against total angle" });
  const hint = h("p", { class: "muted" });
  host.append(svg, hint);
  const redraw = paced(INTERVAL, draw);
  new ResizeObserver(([{ contentRect }]) => {
    size = contentRect;
    redraw();
  }).observe(host);

  function draw() {
    const { width, height } = size;
    const all = [...points, ...rivals, ...(now ? [now] : [])];
    hint.hidden = all.length > 1;
    hint.textContent = now ? "Trace path shows here what each number of cones would leave." : "What the cones buy appears here.";
    svg.toggleAttribute("hidden", all.length < 2);
    if (all.length < 2 || width < 120 || height < 60) return;

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

    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
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
    // Texts that are there already: the label of the current point goes first.
    const taken = [];
    const isFree = (box) => !taken.some((other) => box.x < other.x + other.w && other.x < box.x + box.w && box.y < other.y + other.h && other.y < box.y + box.h);
    const label = (point, text, kind) => {
      const w = text.length * 6.6 + 4;
      const sides = [[x(point) + 8, y(point) - 14], [x(point) + 8, y(point) - 7], [x(point) + 8, y(point) + 2], [x(point) - 8 - w, y(point) - 14], [x(point) - 8 - w, y(point) + 2]];
      const boxes = sides.map(([left, up]) => ({ x: left, y: up, w, h: 14 })).filter((box) => box.x >= LEFT && box.x + w <= width && box.y >= 0 && box.y + 14 <= floor);
      const box = boxes.find(isFree) ?? (kind === "small" ? undefined : boxes[0]);
      if (!box) return;
      taken.push(box);
      nodes.push(s("text", { class: kind, x: box.x + 2, y: box.y + 11 }, text));
    };
    if (now) {
      nodes.push(s("circle", { class: "here", cx: x(now), cy: y(now), r: 4 }));
      label(now, `${plural(now.count, "cone")}, λ ${dial(now.lambda)}`, "strong");
    }
    for (const rival of rivals) {
      nodes.push(s("circle", { class: "second", cx: x(rival), cy: y(rival), r: 3.5 }));
      label(rival, `${rival.label.split(",")[0]}, ${count(rival.count)}`, "second");
    }
    let last = null;
    for (const point of points) {
      if (last && Math.hypot(x(point) - x(last), y(point) - y(last)) < SPARSE) continue;
      if (last && last.count === point.count) continue;
      last = point;
      nodes.push(s("circle", { class: "first", cx: x(point), cy: y(point), r: 2.2 }));
      label(point, count(point.count), "small");
    }
    svg.replaceChildren(...nodes);
    const here = now ? `: ${plural(now.count, "cone")} with ${pi(now.total_angle)} in all leave ∫u² = ${fixed(now.int_u2, 4)}` : "";
    svg.setAttribute("aria-label", `Distortion against total angle${here}`);
  }

  return {
    /** Takes a `cones` event. */
    show(event) {
      now = { lambda: event.lambda, count: event.cones.length, total_angle: event.total_angle, int_u2: event.int_u2 };
      redraw();
    },
    /** Takes a `cone_path` event. */
    path(event) {
      points = event.points;
      redraw();
    },
    /** Takes the rows of a comparison other than the optimum. */
    rivals(rows) {
      rivals = rows;
      redraw();
    },
    clear() {
      [points, now, rivals] = [[], null, []];
      redraw();
    },
  };
}
