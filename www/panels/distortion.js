// What cones buy: the distortion that is left and the angle that is spent, against each other or both over λ.

import { h, paced, s } from "../dom.js";
import { recall, remember } from "../storage.js";
import { overAngle } from "./over-angle.js";
import { overPrice } from "./over-price.js";

const INTERVAL = 100;
const DRAWINGS = { angle: overAngle, price: overPrice };
const KEPT = "distortion plot";

/** `choice` is the select that says which drawing is shown. */
export function distortionPlot(host, choice) {
  let points = [];
  let now = null;
  let rivals = [];
  let isWhole = false;
  let size = { width: 0, height: 0 };
  const svg = s("svg", { role: "img" });
  const hint = h("p", { class: "muted" });
  host.append(svg, hint);
  const redraw = paced(INTERVAL, draw);
  new ResizeObserver(([{ contentRect }]) => {
    size = contentRect;
    redraw();
  }).observe(host);
  const kept = recall(KEPT);
  if (kept in DRAWINGS) choice.value = kept;
  choice.addEventListener("change", () => {
    remember(KEPT, choice.value);
    redraw();
  });

  function draw() {
    const { width, height } = size;
    const isPrice = choice.value === "price";
    // An exact number of cones has no price either.
    const here = isPrice && now?.isPlaced ? null : now;
    // Rivals have no price.
    const isEnough = points.length + (isPrice ? 0 : rivals.length) + (here ? 1 : 0) > 1;
    hint.hidden = isEnough;
    hint.textContent = isWhole && points.length === 0 ? "The cones are the same for every λ: there is no path." : now?.isPlaced ? "Compare with greedy shows both here." : now ? "Trace path shows here what each number of cones would leave." : "What the cones buy appears here.";
    svg.toggleAttribute("hidden", !isEnough);
    if (!isEnough || width < 120 || height < 60) return;
    const { nodes, label } = DRAWINGS[choice.value]({ points, now: here, rivals, width, height });
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("aria-label", label);
    svg.replaceChildren(...nodes);
  }

  return {
    /** Takes a `cones` event. */
    show(event) {
      now = { lambda: event.lambda, count: event.cones.length, raw: event.raw_count, isPlaced: event.is_placed, total_angle: event.total_angle, int_u2: event.int_u2 };
      redraw();
    },
    /** Takes a `cone_path` event. */
    path(event) {
      points = event.points;
      isWhole = event.is_complete;
      redraw();
    },
    /** Takes the rows of a comparison other than the optimum. */
    rivals(rows) {
      rivals = rows;
      // They have no price of their own.
      if (rows.length > 0) choice.value = "angle";
      redraw();
    },
    clear() {
      [points, now, rivals, isWhole] = [[], null, [], false];
      redraw();
    },
  };
}
