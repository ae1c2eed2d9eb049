// What the page shows where, as the method, the mesh and what is in hand have it.

import { byId } from "./dom.js";
import { wordsOf } from "./fields.js";
import { measure, patternIn, patternLength } from "./format.js";
import { METHODS } from "./method-words.js";
import { hasValues, lengthOf, tipNodes } from "./panels/tip.js";

/** Why what needs a cut cannot be had. */
const BLOCKED = "Repair the mesh first: see Mesh, at the top of the parameters";

/** `page` holds the parts of the page, `act` what people do with them. */
export function arrangement(page, act) {
  const { now } = page;

  const words = () => METHODS[now.method] ?? METHODS.cutflow;

  /** What Learn says of the method as a whole. */
  function figures() {
    if (now.method === "cones") return page.cones.figures();
    return now.rows.filter(({ now: value }) => value !== null).map(({ label, now: value, unit }) => [label, measure(value, unit)]);
  }

  /** Arranges the page for a method: the engine has changed to it. */
  function toMethod(id) {
    now.method = id;
    now.stages = null;
    // What was said was said of the other method.
    page.say(null);
    document.documentElement.dataset.method = id;
    page.plot.clear();
    page.status.clear();
    const isCones = id === "cones";
    for (const [pane, isShown] of [["energy", !isCones], ["pieces", !isCones], ["distortion", isCones], ["cones", isCones]]) {
      byId(pane).hidden = !isShown;
    }
    const { hide, sheet: names } = words();
    byId("hide-seams").setAttribute("aria-label", hide[0]);
    byId("hide-seams").title = hide[1];
    page.sheet.name(names);
    byId("energy").querySelector("h3").textContent = names.energy;
    page.plot.call(words().plot ?? "Total J");
    page.cones.show(isCones);
    page.exports.setMethod(id);
    page.learn.setMethod(id, words().learn);
    byId("parameters").setAttribute("aria-labelledby", `tab-${id}`);
    sayHint();
    explainEmpty();
  }

  /** Shows the sizes of the pattern in the unit of the page. */
  function showPattern() {
    now.pattern = patternIn(now.measured, now.unit);
    if (page.views.pixelsPerUnit() > 0) {
      page.measureRuler.show(page.views.pixelsPerUnit(), now.pattern);
      page.texture.show(now.pattern);
    }
    page.updateLegends();
  }

  /** Shows where the pattern must not be cut: its rows among the measures, and a piece in both views. */
  function showFaults(ids, patch) {
    page.sheet.toMeasures();
    page.views.setHover(patch);
    page.measures.reveal(ids);
  }

  function sayHint() {
    const text = byId("hint").querySelector("span");
    if (!text) return;
    if (page.brush.isOn()) text.textContent = "Drag to paint, beside the surface to turn · ";
    else if (page.cones.tool.isOn()) text.textContent = "Click to add a cone, drag to turn · ";
    else if (page.looks.isMeasuring()) text.textContent = "Click to measure, drag to turn · ";
    else text.textContent = now.method === "cones" ? "Drag to turn, or to move a cone · " : "Drag to turn · ";
  }

  /** What is marked on the surface in place of the pieces, as a sentence; null for the pieces. */
  function marked() {
    const { doctor } = now;
    if (doctor?.shown) return doctor.findings.find(({ id }) => id === doctor.shown)?.text ?? "What was found";
    return isBlocked() ? "What must be repaired before the mesh can be cut" : null;
  }

  function isBlocked() {
    return now.doctor ? !now.doctor.solvable : now.mesh?.solvable === false;
  }

  /** Switches off what the mesh does not allow yet, and says so. */
  function allow() {
    const reason = isBlocked() ? BLOCKED : null;
    page.status.block(reason);
    page.exports.block(reason);
    byId("learn").disabled = reason !== null;
    page.fold.block(reason);
    const isFolded = page.fold.isOn() ? "End the fold preview first" : null;
    page.brush.block(reason ?? isFolded);
    page.cones.tool.block(reason ?? isFolded);
    page.looks.block(reason ?? isFolded);
    byId("compare").disabled = reason !== null;
    page.compare.block(reason);
    byId("hide-seams").disabled = (reason ?? isFolded) !== null;
    if (reason !== null) page.learn.close();
    for (const select of document.querySelectorAll("select.overlay")) {
      select.disabled = reason !== null;
      select.title = reason ?? "";
    }
    explainEmpty();
    page.updateLegends();
  }

  /** Says why the flattened view has nothing to show, where it has not. */
  function explainEmpty() {
    if (page.status.state() === "empty") page.empty.show("none");
    else if (isBlocked()) page.empty.show("blocked", now.doctor?.repair_all.length > 0);
    else if (now.doctor?.shown) page.empty.show("marked");
    // A method may be refused on a surface whose chart is there from before.
    else page.empty.show(page.status.isUncut() && !hasChart() ? words().empty : null);
  }

  /** No mesh is open. */
  function showNothing() {
    page.status.show({ state: "empty", step: 0, text: "Ready: open a mesh or choose a sample" });
    explainEmpty();
  }

  const hasChart = () => now.scene?.patches.some((patch) => patch.has_chart) === true;

  function openMeshSection() {
    page.learn.close();
    page.sheet.toParameters();
    page.meshPanel.open();
  }

  function tipFor(patch, pointed = {}) {
    if (marked() !== null) return [];
    const { patches = [], field = null } = now.scene ?? {};
    return tipNodes({ patches, field, piece: page.pieces.piece(patch), pattern: now.pattern }, patch, pointed);
  }

  /** How values of the field that is shown are written; null where it has none. */
  function fieldWords() {
    const field = now.scene?.field;
    if (!hasValues(field) || marked() !== null) return null;
    const { label, value } = wordsOf(field);
    return { name: label, value };
  }

  /** Shows the piece alone that was pointed at last, or all of them again. */
  function isolatePiece() {
    const { look } = page.views;
    if (look.isolated() < 0 && look.last() < 0) page.say("Point at a piece first, then press I.");
    else look.isolate(look.last());
  }

  function showMeasured({ straight_mm, along_mm, path }) {
    const length = (mm) => {
      const { unit_length, unit } = patternIn({ width: 0, height: 0, unit: "mm", unit_length: mm }, now.unit);
      return `${patternLength(unit_length, unit)}\u00a0${unit}`;
    };
    const straight = `${length(straight_mm)} straight`;
    const along = along_mm === null ? "no way along the surface" : `${length(along_mm)} along the surface`;
    const onChart = lengthOf(page.views.look.chartLength(), now.pattern);
    const flat = onChart ? `${onChart} on the chart` : "";
    page.views.look.showMeasured(path, [along_mm === null ? straight : length(along_mm), onChart ?? ""]);
    page.looks.tellEnds(2, [along, straight, flat].filter(Boolean).join(" · "));
  }

  /** Escape puts away what is in hand, the newest first; false if there is nothing. */
  function putAway() {
    if (page.looks.isMeasuring()) page.looks.endMeasure();
    else if (!page.views.look.unpin()) {
      if (page.views.look.isolated() < 0) return false;
      isolatePiece();
    }
    return true;
  }

  return {
    words,
    figures,
    toMethod,
    showPattern,
    showFaults,
    sayHint,
    marked,
    allow,
    explainEmpty,
    showNothing,
    openMeshSection,
    tipFor,
    fieldWords,
    isolatePiece,
    showMeasured,
    putAway,
  };
}
