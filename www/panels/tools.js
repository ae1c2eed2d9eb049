// The tools over the views that need no panel of their own.

import { byId } from "../dom.js";
import { FLAT, SURFACE } from "../view-names.js";
import { fixed, percent } from "../format.js";

/** A button that stays pressed; `change(isOn)` follows it. */
function toggle(id, change) {
  const button = byId(id);
  button.addEventListener("click", () => {
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(on));
    change(on);
  });
}

/**
 * Wires the buttons that only change the pictures. A drag turns, moves or paints: choosing one of the first two
 * calls `putBrush()`. Gives `held(isBrush)`, which shows whether the drag paints.
 */
export function viewTools(views, putBrush) {
  toggle("wireframe", (on) => views.setWireframe(on));
  byId("fit-surface").addEventListener("click", () => views.fit(SURFACE));
  byId("fit-pattern").addEventListener("click", () => views.fit(FLAT));
  let pans = false;
  const held = (isBrush) => {
    byId("orbit").setAttribute("aria-pressed", String(!isBrush && !pans));
    byId("pan").setAttribute("aria-pressed", String(!isBrush && pans));
  };
  for (const id of ["orbit", "pan"]) {
    byId(id).addEventListener("click", () => {
      pans = id === "pan";
      views.setPanTool(pans);
      putBrush();
      held(false);
    });
  }
  return { held };
}

/** The preview that rebuilds the surface from its flat pieces. `begin()` and `end()` are asked of the engine. */
export function foldTool(begin, end) {
  const button = byId("fold");
  const { title } = button;
  let state = null;
  button.addEventListener("click", () => (state?.is_on ? end() : begin()));
  return {
    /** Takes a `fold` event. */
    show(event) {
      state = event;
      button.setAttribute("aria-pressed", String(event.is_on));
      if (!button.disabled) button.title = event.is_on ? "Back to the surface as it is" : title;
    },
    /** Takes the reason why there is nothing to fold, null where there is. */
    block(reason) {
      button.disabled = reason !== null;
      button.title = reason ?? title;
    },
    isOn: () => state?.is_on === true,
    /** `[strong, text]` for the legend while the preview is on, else null. */
    line() {
      if (!state?.is_on) return null;
      const { step, distance_mean: mean, distance_max: most, stretch } = state;
      const off = [mean, most].every(Number.isFinite) ? `off by ${percent(mean)} of √A, ${percent(most)} at most` : "";
      const left = Number.isFinite(stretch) ? `stretch left ${fixed(stretch, 4)}` : "";
      return ["Folded from the flat pieces", [off, left, `step ${step}`].filter(Boolean).join(" · ")];
    },
    /** Another engine, which shows no preview. */
    clear() {
      if (state) this.show({ ...state, is_on: false });
    },
  };
}
