// What a field and its values are called. The engine keeps the change of area as the log of a length ratio, which is
// symmetric and nobody's everyday number: people read it as per cent of the area.

import { among, fixed, MINUS, short } from "./format.js";

/** `+0.10` and `−0.10`; the ends of a range want no more digits than tell them apart. */
function end(value, { range, signed }) {
  const size = Math.abs(value);
  const few = size >= 100 ? 0 : size >= 1 ? 1 : size >= 0.1 ? 2 : 3;
  // From 1.000 to 1.031 takes more digits than 1.0.
  const width = range[1] - range[0];
  const apart = width > 0 ? Math.min(6, Math.ceil(-Math.log10(width)) + 1) : 0;
  const text = size >= 1e-3 && size < 1e4 ? fixed(value, apart > few && !signed ? apart : few) : short(value);
  return signed && value > 0 ? `+${text}` : text;
}

/** How much larger the area is in the chart than on the surface: `+12.3 %`, `−4.1 %`. */
function areaChange(logScale, isEnd = false) {
  const change = 100 * Math.expm1(2 * logScale);
  const size = Math.abs(change);
  const text = fixed(size, size >= 100 || (isEnd && size >= 10) ? 0 : size >= 1 ? 1 : 2);
  const sign = /[1-9]/.test(text) ? (change > 0 ? "+" : MINUS) : "";
  return `${sign}${text}\u202f%`;
}

/**
 * `{ label, unit, end(value), value(value) }` of a field: its name, what its numbers are, and how the ends of its
 * range and other values are written.
 */
export function wordsOf(field) {
  if (field.id === "area") {
    return { label: "Area distortion", unit: "change of area", end: (value) => areaChange(value, true), value: (value) => areaChange(value) };
  }
  const size = Math.max(...field.extremes.map(Math.abs));
  return { label: field.label, unit: field.unit, end: (value) => end(value, field), value: (value) => among(value, size) };
}
