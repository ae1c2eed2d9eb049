// What one does with the views beside turning them: flies to a piece, looks at it alone or from a side, cuts the surface open,
// pins values, measures. The viewer does all of it; this file says when.

import { pinLabels } from "./pins.js";
import { FLAT, SURFACE } from "./view-names.js";

/** A flight takes this long, and none where less motion is wanted. */
const FLIGHT_MS = 420;
/** A double click takes back the pins that its first clicks have set. */
const DOUBLE_MS = 700;


const wantsLess = matchMedia("(prefers-reduced-motion: reduce)");

/**
 * @param hosts the elements of both views
 * @param viewer gives the viewer, null while there is none
 * @param on `isolated(patch)` -1 for none, `measured(from, to)` two places, `ends(count)` while measuring, `words()` gives how the field's values
 * are written, null where none is shown
 */
export function looking(hosts, viewer, on) {
  /** When the flight began; 0 while there is none. */
  let start = 0;
  let isOrthographic = false;
  let clip = { axis: "none", kept: 1, isTurned: false };
  let isolated = -1;
  /** Where a piece was pointed at or flown to last. */
  let last = -1;
  let measures = false;
  let end = null;
  let ends = 0;
  let said = ["", ""];
  /**
   * Pins in the order in which they were set, `{ pin, at, seen }`: `pin` is null where the viewer that knew it is lost, `seen` is the camera
   * that had its point in sight last, and where.
   */
  let pins = [];
  const labels = hosts.map((host) => pinLabels(host, remove));

  function fly() {
    if (wantsLess.matches) viewer()?.fly(1);
    else start = performance.now();
  }

  function remove(pin) {
    pins = pins.filter((other) => other.pin !== pin);
    viewer()?.remove_pin(pin);
  }

  /** Remembers from where each pin can be seen: what another viewer needs to set it at the same point. */
  function remember(numbers) {
    if (isolated >= 0 || start > 0) return;
    const { clientWidth: width, clientHeight: height } = hosts[SURFACE];
    const camera = { pose: viewer().pose(), isOrthographic, clip, width, height };
    for (let i = 0; i + 4 < numbers.length; i += 5) {
      const [pin, x, y, , isHidden] = numbers.slice(i, i + 5);
      const known = pins.find((other) => other.pin === pin);
      if (known && isHidden === 0) known.seen = { x, y, camera };
    }
  }

  /** Sets pins anew that were lost with a viewer: the same clicks under the same cameras. */
  function replant() {
    const [lost, pose] = [pins.filter(({ pin }) => pin === null), viewer().pose()];
    if (lost.length === 0) return;
    const look = ({ pose, isOrthographic, clip, width, height }) => {
      viewer().resize(SURFACE, width, height, devicePixelRatio || 1);
      viewer().set_orthographic(isOrthographic);
      viewer().set_clip(clip.axis, clip.kept, clip.isTurned);
      viewer().set_pose(pose);
    };
    for (const known of lost) {
      if (!known.seen) continue;
      look(known.seen.camera);
      known.pin = viewer().add_pin(SURFACE, known.seen.x, known.seen.y);
    }
    const { clientWidth: width, clientHeight: height } = hosts[SURFACE];
    look({ pose, isOrthographic, clip, width, height });
    pins = pins.filter(({ pin }) => pin !== null && pin >= 0);
  }

  function isolate(patch) {
    viewer()?.set_isolated(patch);
  }

  function clearMeasure() {
    end = null;
    said = ["", ""];
    viewer()?.clear_measure();
  }

  return {
    /** Another viewer has taken the place of the one that was lost. */
    restore(viewer) {
      viewer.set_orthographic(isOrthographic);
      viewer.set_clip(clip.axis, clip.kept, clip.isTurned);
      pins = pins.map((known) => ({ ...known, pin: null }));
      isolated = -1;
      [end, ends] = [null, 0];
      on.isolated(-1);
    },
    /** To be called each frame before it is drawn. */
    frame() {
      if (start === 0) return;
      if (!viewer()?.fly((performance.now() - start) / FLIGHT_MS)) start = 0;
    },
    /** To be called after something was drawn. */
    drawn() {
      const words = on.words();
      if (words) replant();
      labels.forEach((label, view) => {
        const numbers = words && pins.length > 0 ? viewer().pin_labels(view) : [];
        if (view === SURFACE && numbers.length > 0) remember(numbers);
        label.show(numbers, words);
        label.showLength(said[view] ? viewer().measure_label(view) : [], said[view]);
      });
      const alone = viewer().isolated();
      if (alone !== isolated) {
        isolated = alone;
        on.isolated(alone);
      }
      const count = viewer().end_count();
      if (count !== ends) {
        ends = count;
        // A new scene may have lost them.
        if (count === 0) [end, said] = [null, ["", ""]];
        on.ends(count);
      }
    },
    pointedAt(patch) {
      if (patch >= 0) last = patch;
    },
    last: () => last,
    isolated: () => isolated,
    /** Flies to a piece in both views; false where there is none. */
    flyTo(patch) {
      if (!viewer()?.fly_to_patch(patch)) return false;
      last = patch;
      fly();
      return true;
    },
    /** Shows a piece alone and frames it, or brings all of them back. Gives false where there is no such piece. */
    isolate(patch) {
      if (!viewer()) return false;
      if (isolated >= 0) {
        isolate(-1);
        viewer().fly_home(0);
        viewer().fly_home(FLAT);
        fly();
        return true;
      }
      if (!viewer().fly_to_patch(patch)) return false;
      isolate(patch);
      fly();
      return true;
    },
    /** Looks from `front`, `back`, `left`, `right`, `top` or `bottom`. */
    lookFrom(side) {
      viewer()?.fly_to_side(side);
      fly();
    },
    setOrthographic(on) {
      isOrthographic = on;
      viewer()?.set_orthographic(on);
    },
    /** Cuts the surface open: `axis` is x, y, z, view, or none; `kept` of its extent stays. */
    setClip(next) {
      clip = { ...clip, ...next };
      viewer()?.set_clip(clip.axis, clip.kept, clip.isTurned);
    },
    /** Whether clicks measure. */
    setMeasure(on) {
      measures = on;
      clearMeasure();
    },
    measures: () => measures,
    clearMeasure,
    /** What stands beside the lines that were measured, `[surface, flat]`, and the way between the ends. */
    showMeasured(path, texts) {
      viewer()?.set_path(new Float32Array(path.flat()));
      said = texts;
    },
    chartLength: () => viewer()?.chart_length() ?? NaN,
    /** A click on a place that is no cone's; true if it meant something. */
    click(at) {
      if (!viewer()) return false;
      if (measures) {
        const pick = viewer().add_end(at.view, at.x, at.y);
        if (!pick) return false;
        said = ["", ""];
        if (end && viewer().end_count() === 2) {
          on.measured(end, pick);
          end = null;
        } else end = pick;
        return true;
      }
      if (!on.words()) return false;
      const pin = viewer().add_pin(at.view, at.x, at.y);
      if (pin >= 0) pins.push({ pin, at: performance.now(), seen: null });
      return pin >= 0;
    },
    /** A double click: flies to the piece there. False where there is none. */
    doubleClick(at) {
      const recent = performance.now() - DOUBLE_MS;
      for (const { pin } of pins.filter((other) => other.at > recent)) remove(pin);
      const patch = viewer()?.pick(at.view, at.x, at.y)?.patch ?? -1;
      return patch >= 0 && this.flyTo(patch);
    },
    /** Takes the newest pin away; false if there is none. */
    unpin() {
      if (pins.length === 0 || !on.words()) return false;
      remove(pins.at(-1).pin);
      return true;
    },
    /** Another mesh. */
    clear() {
      pins = [];
      last = -1;
      clearMeasure();
    },
  };
}
