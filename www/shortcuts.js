// What single keys do.

import { byId } from "./dom.js";
import { listenToKeys } from "./keys.js";
import { FLAT, SURFACE } from "./view-names.js";

/** `page` holds the parts of the page, `act` what people do with them; `isOverCharts()` says where the pointer is, `help()` shows the keys. */
export function listenToShortcuts({ status, error, brush, cones, learn, looks, views }, act, isOverCharts, help) {
  const press = (id) => !byId(id).disabled && !byId(id).hidden && byId(id).click();
  listenToKeys({
    press,
    dismiss: () => error.dismiss(),
    held: (name) => brush.key(name) || (!learn.isOpen() && cones.key(name)) || (name === "Escape" && act.putAway()),
    actions: {
      o: () => byId("file").click(),
      " ": () => press(status.state() === "running" ? "pause" : "run"),
      ".": () => press("step"),
      r: () => press("reset"),
      f: () => views.fit(isOverCharts() ? FLAT : SURFACE),
      w: () => press("wireframe"),
      c: () => press("checkerboard"),
      b: () => learn.isOpen() || press("brush"),
      a: () => learn.isOpen() || press("add-cone"),
      1: () => looks.look("front"),
      "Shift 1": () => looks.look("back"),
      3: () => looks.look("right"),
      "Shift 3": () => looks.look("left"),
      7: () => looks.look("top"),
      "Shift 7": () => looks.look("bottom"),
      5: looks.toggleOrthographic,
      i: act.isolatePiece,
      x: looks.toggleClip,
      d: () => learn.isOpen() || looks.toggleMeasure(),
      "?": help,
    },
  });
}
