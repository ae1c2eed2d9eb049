// What the two canvases show, in words, for those who do not see them: read with the name of the canvas that has the focus.
// The tables of pieces and measures say the rest.

import { h, paced, write } from "../dom.js";
import { wordsOf } from "../fields.js";
import { measure, patternLength, percent, plural } from "../format.js";

const INTERVAL = 500;
export const DESCRIPTIONS = ["surface-words", "flat-words"];
const HOW = [
  "Arrow keys turn it, with Shift they move it, plus and minus zoom, F fits it.",
  "Arrow keys move it, plus and minus zoom, F fits it.",
];

/** A piece in a few words: its number, its share, its seam. */
function pieceWords({ area_fraction: share, seam_length: seam }, i) {
  return `piece ${i + 1} has ${percent(share)} of the area${Number.isFinite(seam) ? ` and a seam of ${measure(seam, "√A")}` : ""}`;
}

/** Longer lists are for the tables. */
const FEW = 6;

function surfaceWords({ name, marked, scene, pieces }) {
  if (marked) return `${name}. ${marked}.`;
  const count = scene.patches.length;
  const isCut = scene.patches.some((patch) => patch.area_fraction > 0);
  if (!isCut) return `${name}, not cut yet.`;
  const list = pieces.length === count && count <= FEW ? `: ${pieces.map(pieceWords).join("; ")}` : "";
  return `${name} in ${plural(count, "piece")}${list}.`;
}

function flatWords({ marked, scene, pattern }) {
  if (marked) return "Nothing is flattened.";
  const charts = scene.patches.filter((patch) => patch.has_chart).length;
  if (charts === 0) return "Nothing is flattened yet.";
  const flipped = scene.patches.reduce((sum, patch) => sum + patch.flipped, 0);
  const size = pattern ? `, ${[pattern.width, pattern.height].map((length) => patternLength(length, pattern.unit)).join(" by ")} ${pattern.unit} together` : "";
  return `${plural(charts, "flat piece")}${size}, ${flipped > 0 ? plural(flipped, "flipped triangle") : "no flipped triangles"}.`;
}

function fieldWords(field) {
  if (!field || field.id === "regions") return "";
  const { label, value } = wordsOf(field);
  return `Coloured by ${label}: least ${value(field.extremes[0])}, mean ${value(field.mean)}, most ${value(field.extremes[1])}.`;
}

/** `facts()` gives `{ name, marked, scene, pieces, pattern }`. Gives a function that says them anew. */
export function descriptions(facts) {
  const nodes = DESCRIPTIONS.map((id) => h("p", { id, hidden: true }));
  [".view.surface", ".view.flat"].forEach((view, i) => document.querySelector(view).append(nodes[i]));
  return paced(INTERVAL, () => {
    const now = facts();
    if (!now.scene) return;
    const field = fieldWords(now.marked ? null : now.scene.field);
    [surfaceWords(now), flatWords(now)].forEach((words, i) => write(nodes[i], [words, field, HOW[i]].filter(Boolean).join(" ")));
  });
}
