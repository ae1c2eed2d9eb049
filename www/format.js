// Numbers as people read them: a true minus sign, narrow spaces between thousands, as many digits as mean something.

const SPACE = "\u202f";
export const MINUS = "\u2212";

/** A fixed number of decimals. */
export function fixed(value, decimals) {
  const [whole, fraction] = Math.abs(value).toFixed(decimals).split(".");
  const grouped = whole.length > 3 ? whole.replace(/\B(?=(\d{3})+$)/g, SPACE) : whole;
  const text = fraction ? `${grouped}.${fraction}` : grouped;
  return value < 0 && /[1-9]/.test(text) ? MINUS + text : text;
}

/** About four digits, whatever the size. */
export function short(value) {
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size < 1e-3 || size >= 1e7) {
    const [mantissa, exponent] = value.toExponential(1).split("e");
    return `${mantissa}e${exponent.replace("+", "")}`.replaceAll("-", MINUS);
  }
  return fixed(value, size >= 1000 ? 0 : size >= 100 ? 1 : size >= 10 ? 2 : 3);
}

/** A value as one of several up to `size`: what is small beside that reads as zero. */
export function among(value, size) {
  if (!(size >= 1e-3 && size < 1e7)) return short(value);
  return fixed(value, size >= 1000 ? 0 : size >= 100 ? 1 : size >= 10 ? 2 : size >= 0.1 ? 3 : 4);
}

/** Three digits that mean something, as a dial would show them: 0.0100, 2.00, 3 000. */
export function dial(value, most = 6) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-3) return value.toExponential(1).replace(".0", "").replaceAll("-", MINUS);
  return fixed(value, Math.min(most, Math.max(0, 2 - Math.floor(Math.log10(size)))));
}

/** Counts are written whole, quantities with about four digits. */
export const count = (value) => fixed(value, 0);

/** A measure with its unit; a dash where there is none. Without a unit whole numbers are counts. */
export function measure(value, unit = "") {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  const text = !unit && Number.isInteger(value) ? count(value) : unit && Math.abs(value) >= 0.1 ? fixed(value, 2) : short(value);
  return unit ? `${text}\u00a0${unit}` : text;
}

/** A fraction as per cent. */
export const percent = (fraction) => `${fraction > 0 && fraction < 5e-4 ? "<\u202f0.1" : fixed(100 * fraction, 1)}\u00a0%`;

/** `1 piece`, `2 pieces`. */
export const plural = (n, one, many = `${one}s`) => `${count(n)} ${n === 1 ? one : many}`;

/** What a person typed, or NaN: spaces, a decimal comma and a true minus sign are understood. */
export function parse(text) {
  const plain = text.replace(/[\s\u202f\u00a0]/g, "").replaceAll(MINUS, "-").replace(",", ".");
  return plain === "" ? NaN : Number(plain);
}

/** An angle in radians in units of π, with two decimals; a smaller one with two digits that mean something, down to a millionth. */
export function inPi(angle) {
  const size = Math.abs(angle / Math.PI);
  return fixed(angle / Math.PI, size > 0 && size < 0.095 ? Math.min(6, 1 - Math.floor(Math.log10(size))) : 2);
}

/** An angle in radians as a multiple of π: `0.44 π`. */
export const pi = (angle) => `${inPi(angle)}\u202fπ`;

/** What a person typed for an angle in units of π, in radians: `0.5`, `-1/2`, `2π/3`. NaN where it says no angle. */
export function parsePi(text) {
  const plain = text.replace(/[\s\u202f\u00a0*·]/g, "").replaceAll(MINUS, "-").replace(",", ".").replace(/pi/i, "π");
  const [, sign, number, symbol, divisor] = /^([+-]?)(\d*\.?\d*(?:e[+-]?\d+)?)(π?)(?:\/(\d+\.?\d*))?π?$/i.exec(plain) ?? [];
  if (number === undefined || (number === "" && symbol === "")) return NaN;
  const value = (number === "" ? 1 : Number(number)) / (divisor === undefined ? 1 : Number(divisor));
  return (sign === "-" ? -1 : 1) * value * Math.PI;
}

/** Round numbers that divide `[0, top]` into about `parts`. */
export function ticks(top, parts, whole = false) {
  if (!(top > 0)) return [0];
  const raw = top / parts;
  const power = 10 ** Math.floor(Math.log10(raw));
  let step = [1, 2, 2.5, 5, 10].find((m) => m * power >= raw * 0.999) * power;
  if (whole) step = Math.max(1, Math.ceil(step));
  const list = [];
  for (let i = 0; i * step <= top * 1.0001; i += 1) list.push(i * step);
  return list;
}

/** The same for `[low, high]` with `low ≤ 0 ≤ high`: ticks on either side of 0. */
export function ticksBetween(low, high, parts) {
  const step = ticks(Math.max(high - low, 1e-300), parts)[1] ?? 1;
  const list = [];
  for (let i = Math.ceil((low / step) * 0.9999); i * step <= high * 1.0001 || i <= 0; i += 1) list.push(i * step);
  return list;
}

/** 1, 2 and 5 times powers of ten inside a range. */
export function rounds(min, max) {
  const list = [];
  for (let k = Math.floor(Math.log10(min)); 10 ** k <= max; k += 1) list.push(...[1, 2, 5].map((m) => Number(`${m}e${k}`)));
  return list.filter((value) => value >= min * (1 - 1e-9) && value <= max * (1 + 1e-9));
}

/** A number without decimals that say nothing. */
export const trimmed = (text) => (/\.\d+$/.test(text) ? text.replace(/\.?0+$/, "") : text);

/** A tick, without decimals that say nothing; large ones by their power of ten: `1.25e5`. */
export function tick(value) {
  if (Math.abs(value) < 1e5) return trimmed(short(value));
  return Number(value.toPrecision(3)).toExponential().replace("+", "").replace("-", MINUS);
}

/** 0.001, 0.01 …: the powers of ten inside a range. */
export function decades(min, max) {
  const list = [];
  for (let k = Math.ceil(Math.log10(min) - 1e-9); 10 ** k <= max * (1 + 1e-9); k += 1) list.push(10 ** k);
  return list;
}

/** A power of ten without zeros that say nothing. */
export const power = (value) => (value >= 1e-4 ? String(Number(value.toPrecision(1))) : dial(value));

/** 1, 2 or 5 times a power of ten: the largest up to `value`. */
export function roundBelow(value) {
  const power = Math.floor(Math.log10(value));
  const factor = [5, 2, 1].find((m) => m * 10 ** power <= value * (1 + 1e-9)) ?? 1;
  return Number(`${factor}e${power}`);
}

/** The same, whichever is nearest by ratio. */
export function roundNear(value) {
  const below = roundBelow(value);
  const above = roundBelow(below * 2.6);
  return value / below < above / value ? below : above;
}

/** A round number without zeros that say nothing: `0.05`, `20`, `2 000`. */
export const roundText = (value) => fixed(value, Math.max(0, -Math.floor(Math.log10(value) + 1e-9)));

const MM = { mm: 1, cm: 10, m: 1000, inch: 25.4 };

/** The sizes of a pattern in the unit that the page shows lengths in; as they are where that is unknown. */
export function patternIn(pattern, unit) {
  if (!pattern || pattern.unit !== "mm" || !MM[unit] || unit === "mm") return pattern;
  const [width, height, unit_length] = [pattern.width, pattern.height, pattern.unit_length].map((length) => length / MM[unit]);
  return { ...pattern, width, height, unit_length, unit };
}

/** A length of a pattern: whole millimetres, else three digits. */
export function patternLength(value, unit) {
  if (!(value > 0)) return "0";
  const decimals = Math.min(6, Math.max(0, 2 - Math.floor(Math.log10(value))));
  return fixed(value, unit === "mm" && value >= 10 ? 0 : decimals);
}
