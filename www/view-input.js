// What the pointer, the wheel and the keys do in a view: turn, move and zoom it, paint, take cones, click. The camera lives in the viewer;
// this file forwards.

import { SURFACE } from "./view-names.js";

/** A turn of the wheel by one notch (100 units) zooms by this factor; trackpads send fractions of it. */
const WHEEL_ZOOM = 1.25;
/** Pixels that one press of an arrow key stands for. */
const KEY_DRAG = 24;
/** A press that moves no further is a click. */
const CLICK_PX = 4;
/** A finger that moves this far paints; one that lifts before has touched, and a second one may still join it. */
const TOUCH_PX = 4;

/**
 * Listens to a view in `host`.
 *
 * @param of what is at hand: `viewer()`, null while there is none, `brush()`, null while it is put away, `hand` for cones, `look` for flights
 * and measures, `pans()` whether a drag moves, `aims()` whether a click sets something, `isConeChosen()`, `canvas()`; and what is to be done:
 * `point(at)` looks at what is there, `aim(at)` puts the ring there, null takes it away, `leave()`, `hideTip()`, `fit()`, `middle()` gives what
 * lies in the middle, `addCone(pick)`
 */
export function listenToView(host, view, of) {
  const pointers = new Map();
  const place = (event) => {
    const box = host.getBoundingClientRect();
    return { view, x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const isSide = (event) => event.pointerType === "mouse" && (event.buttons & 6) !== 0;
  const turns = (event) => {
    if (view !== SURFACE) return false;
    // With a brush in hand the other button and Shift stand for the drag that turns.
    if (of.brush()) return !isSide(event) || (event.buttons & 2) !== 0;
    return !of.pans() && !event.shiftKey && !isSide(event);
  };
  const paints = (event) => view === SURFACE && of.brush() && of.viewer() && !event.shiftKey && !isSide(event);
  /** The pointer that paints, and where a finger has touched that may be about to. */
  let painter = null;
  let touched = null;
  /** The press that may become a click. */
  let pressed = null;
  const paint = (at, event, begins) => {
    const picks = of.viewer()?.stroke(at.x, at.y, of.brush().radius(), begins) ?? [];
    if (picks.length > 0) of.brush().stroke(picks, begins, event.altKey);
    return picks.length > 0;
  };

  host.addEventListener("pointerdown", (event) => {
    if (pointers.size === 2) return;
    const isFree = pointers.size === 0 && event.button === 0 && !event.shiftKey && !of.brush() && !of.hand.adds();
    // A click beside a chosen cone lets go of it and does no more.
    pressed = isFree && !of.isConeChosen() ? place(event) : null;
    host.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, place(event));
    of.canvas()?.focus({ preventScroll: true });
    if (view === SURFACE && (of.brush() || of.aims())) of.aim(place(event));
    if (pointers.size > 1) of.hand.cancel();
    else if (!(of.brush() && view === SURFACE) && of.hand.down(view, place(event), event)) {
      of.hideTip();
      pressed = null;
      host.classList.add("dragging");
      return;
    }
    if (pointers.size === 1 && paints(event)) {
      if (event.pointerType === "touch") touched = place(event);
      else if (paint(place(event), event, true)) {
        painter = event.pointerId;
        of.hideTip();
        return;
      }
    } else [painter, touched] = [null, null];
    host.classList.add("dragging");
    if (event.pointerType !== "mouse") of.point(place(event));
    else of.hideTip();
  });
  host.addEventListener("pointermove", (event) => {
    const at = place(event);
    const before = pointers.get(event.pointerId);
    if (view === SURFACE && (of.brush() || of.aims())) of.aim(at);
    if (pressed && Math.hypot(at.x - pressed.x, at.y - pressed.y) > (event.pointerType === "touch" ? 2 : 1) * CLICK_PX) pressed = null;
    if (!before) {
      of.point(at);
      return;
    }
    if (touched && of.brush()) {
      if (Math.hypot(at.x - touched.x, at.y - touched.y) < TOUCH_PX) return;
      if (paint(touched, event, true)) painter = event.pointerId;
      touched = null;
    }
    pointers.set(event.pointerId, at);
    if (!of.viewer() || of.hand.move(at, event)) return;
    if (painter === event.pointerId && of.brush()) {
      for (const part of event.getCoalescedEvents?.() ?? []) paint(place(part), event, false);
      paint(at, event, false);
      return;
    }
    if (pointers.size === 1) {
      if (turns(event)) of.viewer().rotate(at.x - before.x, at.y - before.y);
      else of.viewer().pan(view, at.x - before.x, at.y - before.y);
    } else {
      // Two fingers: half of each one's movement, and the change of their distance.
      const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, point]) => point);
      of.viewer().pan(view, (at.x - before.x) / 2, (at.y - before.y) / 2);
      const distance = (point) => Math.hypot(point.x - other.x, point.y - other.y);
      if (distance(before) > 0) {
        of.viewer().zoom(view, distance(at) / distance(before), (at.x + other.x) / 2, (at.y + other.y) / 2);
      }
    }
  });
  const release = (event) => {
    if (touched && of.brush() && event.type === "pointerup") paint(touched, event, true);
    [painter, touched] = [null, null];
    if (event.type === "pointerup") of.hand.up(event);
    else of.hand.cancel();
    if (event.type === "pointerup" && pressed && pointers.size === 1) of.look.click(pressed);
    pressed = null;
    if (event.pointerType === "touch") of.aim(null);
    pointers.delete(event.pointerId);
    if (pointers.size === 0) host.classList.remove("dragging");
  };
  host.addEventListener("pointerup", release);
  host.addEventListener("pointercancel", release);
  host.addEventListener("pointerleave", (event) => {
    if (pointers.size === 0) of.aim(null);
    if (event.pointerType === "mouse" && pointers.size === 0) of.leave();
  });
  host.addEventListener("contextmenu", (event) => event.preventDefault());
  host.addEventListener("dblclick", (event) => {
    if (of.brush() || of.aims() || of.look.doubleClick(place(event))) return;
    of.fit();
  });
  host.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      // Lines and pages count as what they usually scroll; a pinch on a trackpad comes as a small wheel with Ctrl.
      const unit = [1, 16, 400][event.deltaMode] * (event.ctrlKey ? 5 : 1);
      const { x, y } = place(event);
      of.viewer()?.zoom(view, WHEEL_ZOOM ** ((-event.deltaY * unit) / 100), x, y);
      of.hideTip();
    },
    { passive: false },
  );
  host.addEventListener("keydown", (event) => {
    if (!of.viewer() || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const zoom = { "+": WHEEL_ZOOM, "=": WHEEL_ZOOM, "-": 1 / WHEEL_ZOOM }[event.key];
    if (step && view === SURFACE && !event.shiftKey) of.viewer().rotate(step[0] * KEY_DRAG, step[1] * KEY_DRAG);
    else if (step) of.viewer().pan(view, step[0] * KEY_DRAG, step[1] * KEY_DRAG);
    else if (zoom) of.viewer().zoom(view, zoom, host.clientWidth / 2, host.clientHeight / 2);
    else if (event.key === "Enter" && view === SURFACE && of.brush()) {
      paint({ x: host.clientWidth / 2, y: host.clientHeight / 2 }, event, true);
    } else if (event.key === "Enter" && view === SURFACE && of.hand.adds()) {
      const pick = of.middle();
      if (pick) of.addCone(pick);
    }
    else if (event.key === "Enter" && of.look.measures()) of.look.click({ view, x: host.clientWidth / 2, y: host.clientHeight / 2 });
    else if (event.key === "f" || event.key === "F" || event.key === "Home") of.fit();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
}
