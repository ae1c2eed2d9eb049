// The page of the method of cones: its panels, what the hand does with cones in the views, and what is sent for it.

import { byId, h } from "./dom.js";
import { dial, fixed, pi, short } from "./format.js";
import { comparisonPanel } from "./panels/comparison.js";
import { conesPanel, kindOf } from "./panels/cones.js";
import { coneTool } from "./panels/cone-tool.js";
import { distortionPlot } from "./panels/distortion.js";
import { pathPanel } from "./panels/path.js";

/**
 * @param on `send(command)` resolves with the answer; `wait(sentence, cancelled, command)` does so with a way out;
 * `lambda(value)` sets λ; `views()` gives the two views; `say(sentence)`; `toolChanged(isOn)` after the tool was taken
 * or put away; `facts(text)` takes the line of figures, null for none
 */
export function coneMethod(on) {
  let isOn = false;
  let last = null;
  let comparing = false;
  /** Where a cone was put that is to be the chosen one as soon as it is there. */
  let awaited = null;
  /** The optimum of the comparison that is shown. */
  let compared = null;
  /** Whether a solution goes on, and what it or the last one has cost. */
  let isSolving = false;
  let spent = 0;
  const views = () => on.views();

  const table = conesPanel(byId("cones"), {
    hover: (cone) => views().markCones({ hover: cone }),
    select,
    setAngle: (cone, angle) => on.send({ type: "set_cone_angle", cone, angle }),
    remove,
    problem: on.say,
  });
  const path = pathPanel({
    trace: () => on.send({ type: "trace_path" }),
    stop: () => on.send({ type: "pause" }),
    clear: () => on.send({ type: "clear_cones" }),
    lambda: on.lambda,
  });
  const plot = distortionPlot(byId("distortion-plot"), byId("distortion-kind"));
  const comparison = comparisonPanel(byId("measures"));
  const tool = coneTool({
    changed(isHeld) {
      views().setConeTool(isHeld);
      on.toolChanged(isHeld);
    },
    problem: on.say,
  });
  byId("compare").addEventListener("click", compare);

  function select(cone) {
    table.select(cone);
    views().markCones({ selected: cone });
  }

  /** The number that the chosen cone has now: numbers change with what is added and removed, vertices do not. */
  function heir(before, cones) {
    if (awaited) {
      const known = new Set(before.map(({ vertex }) => vertex));
      const distance = ({ place }) => Math.hypot(...place.map((x, k) => x - awaited[k]));
      const [nearest] = cones.filter(({ vertex }) => !known.has(vertex)).sort((a, b) => distance(a) - distance(b));
      if (nearest) {
        awaited = null;
        return nearest.cone;
      }
    }
    const vertex = before.find(({ cone }) => cone === table.selected())?.vertex;
    return cones.find((cone) => cone.vertex === vertex)?.cone ?? -1;
  }

  function remove(cone) {
    on.send({ type: "remove_cone", cone });
  }

  async function move(cone, { face, x, y, z }) {
    select(cone);
    awaited = [x, y, z];
    const answer = await on.send({ type: "move_cone", cone, face, place: [x, y, z] });
    // A refused cone goes back to where it was.
    if (answer.events.some(({ type }) => type === "error")) {
      awaited = null;
      views().dropCone();
    }
  }

  function add({ face, x, y, z }) {
    const angle = tool.value();
    if (angle === undefined) return;
    awaited = [x, y, z];
    on.send({ type: "add_cone", face, place: [x, y, z], angle });
  }

  async function compare() {
    if (comparing) return;
    comparing = true;
    await on.wait("Placing cones greedily, to compare", "The comparison was cancelled.", { type: "compare_cones" });
    comparing = false;
    comparison.reveal();
  }

  /** A comparison is with the cones that it was made for. */
  function judge(event) {
    const isSame = (a, b) => Math.abs(a - b) <= 1e-9 * Math.abs(b);
    if (!compared || (event.cones.length === compared.count && isSame(event.total_angle, compared.total_angle) && isSame(event.int_u2, compared.int_u2))) return;
    compared = null;
    comparison.hide();
    plot.rivals([]);
  }

  function figures(event) {
    const time = spent > 0 ? [`${spent < 10 ? fixed(spent, 1) : fixed(spent, 0)}\u202fms`] : [];
    if (event.is_placed) return [...time, "places by local search"].join(", ");
    const part = event.lambda / event.lambda_max;
    // From λ_max on a higher price changes nothing.
    const place = part > 1 ? `above λ_max ${dial(event.lambda_max)}` : `${fixed(100 * part, 1)}\u202f% of λ_max`;
    // An estimate may be several times too large.
    const share = event.lambda_max > 0 && event.is_lambda_max_exact ? `λ ${dial(event.lambda)}, ${place}` : `λ ${dial(event.lambda)}`;
    const certificate = event.is_edited ? ["edited by hand"] : [`residual ${short(event.kkt_residual)}`, `gap ${short(event.gap)}`];
    return [...time, share, ...certificate].join(", ");
  }

  return {
    handlers: {
      cones(event) {
        const before = last?.cones ?? [];
        last = event;
        const chosen = heir(before, event.cones);
        judge(event);
        table.show(event, chosen);
        views().markCones({ selected: chosen });
        path.show(event);
        plot.show(event);
        on.facts(isOn ? figures(event) : null);
      },
      cone_path(event) {
        path.path(event);
        plot.path(event);
      },
      cone_comparison(event) {
        compared = event.rows[0] ?? null;
        comparison.show(event);
        // The refitted angles may lie where the optimum does: they are told in the table only.
        plot.rivals(event.rows.slice(1, 2));
      },
    },
    /** What stands above the slider of λ, and below all sliders beside it. */
    path: path.node,
    foot: path.foot,
    /** Takes the specs of the parameters. */
    specs: (specs) => path.spec(specs.find(({ id }) => id === "lambda")),
    /** Takes a `status` event: a solution begins, a path is traced, or neither. */
    status({ state, text }) {
      const runs = state === "running";
      const traces = runs && /tracing/i.test(text);
      path.tracing(isOn && traces);
      if (runs && !traces && !isSolving) spent = 0;
      isSolving = runs && !traces;
      if (isOn && last && !runs) on.facts(figures(last));
    },
    /** Milliseconds that the engine has spent. */
    spent(milliseconds) {
      if (isSolving) spent += milliseconds;
    },
    /** Whether this is the method that is chosen. */
    show(isChosen) {
      isOn = isChosen;
      views().setCones(isOn);
      tool.offer(isOn);
      if (!isOn) {
        select(-1);
        comparison.hide();
      }
      on.facts(isOn && last ? figures(last) : null);
    },
    /** Another mesh. */
    clear() {
      [last, compared, awaited, spent] = [null, null, null, 0];
      select(-1);
      table.show({ cones: [], note: null }, -1);
      path.clear();
      plot.clear();
      comparison.hide();
      on.facts(null);
    },
    tool,
    /** What the views ask and tell. */
    hoverCone: (cone) => table.hover(cone),
    selectCone: select,
    moveCone: move,
    addCone: add,
    describeCone(id) {
      const cone = table.cone(id);
      if (!cone) return [];
      const partner = cone.partner === null || cone.partner === undefined ? null : `partner: cone ${cone.partner + 1}`;
      return [h("b", {}, `Cone ${id + 1}`), ` ${pi(cone.angle)}`, ...[kindOf(cone), partner].filter(Boolean).flatMap((text) => [h("br"), text])];
    },
    /** What a key does while cones are there; false for keys that mean nothing here. */
    key(name) {
      if (!isOn) return false;
      const cone = table.selected();
      if (name === "Escape") {
        if (views().cancelMove()) return true;
        if (tool.isOn()) tool.put();
        else if (cone >= 0) select(-1);
        else return false;
        return true;
      }
      if (cone < 0) return false;
      if (name === "Delete" || name === "Backspace") remove(cone);
      else if (name === "Enter" && document.activeElement?.tagName === "CANVAS" && !tool.isOn()) table.edit(cone);
      else if (name === "m") {
        const middle = views().middle();
        if (middle) move(cone, middle);
        else on.say("There is no surface in the middle of the view: turn it until the place is there, then press M.");
      } else return false;
      return true;
    },
    /** What Learn tells of the solution: `[name, text]`. */
    figures() {
      if (!last) return [];
      if (last.is_placed) return [["Cones shown", String(last.cones.length)], ["Total angle Σ|μ|", pi(last.total_angle)], ["Distortion ∫u²", fixed(last.int_u2, 4)]];
      const { lambda, lambda_max: most, is_lambda_max_exact: isExact, raw_count: raw, cones, total_angle: total } = last;
      return [
        ["Price λ", dial(lambda)],
        ["λ_max", isExact ? dial(most) : "traced with the path"],
        ["Vertices that are cones", String(raw)],
        ["Cones shown", String(cones.length)],
        ["Total angle Σ|μ|", pi(total)],
        ["Distortion ∫u²", fixed(last.int_u2, 4)],
        ["Residual, gap", `${short(last.kkt_residual)}, ${short(last.gap)}`],
      ];
    },
  };
}
