// What the tip beside the pointer says of a place: its seam, or its piece, and the value of the field there.

import { h } from "../dom.js";
import { wordsOf } from "../fields.js";
import { measure, patternLength, percent } from "../format.js";

/** A length of the scene in the unit of the page; null where its size is not known. */
export function lengthOf(length, pattern) {
  const real = length * (pattern?.unit_length ?? 0);
  return real > 0 ? `${patternLength(real, pattern.unit)}\u00a0${pattern.unit}` : null;
}

/** Whether a field has values to read: labels are names. */
export const hasValues = (field) => Boolean(field) && field.id !== "regions";

/**
 * The nodes of the tip. `facts` are `{ patches, field, piece, pattern }`: what is known of all pieces, the field shown, the measures of
 * the piece; `pointed` is what the viewer says of the place.
 */
export function tipNodes({ patches, field, piece, pattern }, patch, pointed) {
  const lines = [];
  const { seam, value } = pointed;
  if (seam) {
    const { a, b, length } = seam;
    const between = a === b ? ` of piece ${a + 1} with itself` : ` between pieces ${Math.min(a, b) + 1} and ${Math.max(a, b) + 1}`;
    lines.push([h("b", {}, "Seam"), between]);
    const size = lengthOf(length, pattern);
    if (size) lines.push([`${size} long`]);
  } else {
    const share = piece?.area_fraction ?? patches[patch]?.area_fraction;
    if (share === undefined) return [];
    lines.push([h("b", {}, `Piece ${patch + 1}`), ` ${percent(share)} of the area`]);
    if (piece?.seam_length !== null && piece?.seam_length !== undefined) lines.push([`seam ${measure(piece.seam_length, "√A")}`]);
    if (piece?.note) lines.push([piece.note]);
  }
  if (hasValues(field) && Number.isFinite(value)) {
    const words = wordsOf(field);
    lines.push([`${words.label} `, h("b", {}, words.value(value))]);
  }
  return lines.flatMap((line, i) => (i > 0 ? [h("br"), ...line] : line));
}
