// What the pointer does with cones: points at one, chooses it, takes it to another place, adds one.

/** A pointer that moves this far drags; less is a click. Fingers tremble. */
const CLICK_PX = 4;
const TOUCH_CLICK_PX = 9;
/** How far beside its glyph a cone can still be taken. */
const SLOP_PX = 3;
const TOUCH_SLOP_PX = 14;

const isTouch = (event) => event.pointerType === "touch";

/**
 * @param viewer gives the viewer, null while there is none
 * @param on `select(cone)` a click, -1 for beside all of them; `move(cone, pick)` when it is let go elsewhere;
 * `add(pick)` a click with the tool
 */
export function coneHand(viewer, on) {
  let isOn = false;
  let adds = false;
  /** What is pressed: a cone that may be dragged, or a place that may be clicked. */
  let pressed = null;

  function cancel() {
    const wasDragging = pressed?.hasMoved === true && pressed.cone >= 0;
    pressed = null;
    if (wasDragging) viewer()?.drop_cone();
    return wasDragging;
  }

  return {
    /** Whether cones can be taken at all. */
    enable(on) {
      isOn = on;
      if (!on) cancel();
    },
    setAdds(on) {
      adds = on;
      cancel();
    },
    adds: () => isOn && adds,
    /** The cone under a place, -1 for none. */
    at: (view, at) => (isOn ? (viewer()?.pick_cone(view, at.x, at.y, SLOP_PX) ?? -1) : -1),
    /** A press; true if the drag that may follow moves a cone. */
    down(view, at, event) {
      pressed = null;
      if (!isOn || !viewer() || event.shiftKey || event.button > 0) return false;
      const cone = viewer().pick_cone(view, at.x, at.y, isTouch(event) ? TOUCH_SLOP_PX : SLOP_PX);
      pressed = { id: event.pointerId, view, from: at, cone, hasMoved: false, pick: null };
      return cone >= 0;
    },
    /** A movement; true if it moves a cone. */
    move(at, event) {
      if (pressed?.id !== event.pointerId) return false;
      const distance = Math.hypot(at.x - pressed.from.x, at.y - pressed.from.y);
      pressed.hasMoved ||= distance > (isTouch(event) ? TOUCH_CLICK_PX : CLICK_PX);
      if (pressed.cone < 0) return false;
      // The cone stays where the surface was last under the pointer.
      if (pressed.hasMoved) pressed.pick = viewer()?.drag_cone(pressed.cone, pressed.view, at.x, at.y) ?? pressed.pick;
      return true;
    },
    up(event) {
      if (pressed?.id !== event.pointerId) return;
      const { cone, view, from, hasMoved, pick } = pressed;
      pressed = null;
      if (cone >= 0 && hasMoved && pick) on.move(cone, pick);
      else if (cone >= 0 && !hasMoved) on.select(cone);
      else if (cone < 0 && !hasMoved && adds) {
        const place = viewer()?.pick(view, from.x, from.y);
        if (place) on.add(place);
      } else if (cone < 0 && !hasMoved) on.select(-1);
    },
    /** Gives up a drag; false if there is none. */
    cancel,
    isDragging: () => pressed !== null && pressed.cone >= 0 && pressed.hasMoved,
  };
}
