// Pictures as numbers.

import { inflateSync } from "node:zlib";

/** Decodes a PNG of 8 bits a channel without interlacing, which is what browsers write: `{ width, height, rgb }`. */
export function decodePng(file) {
  const width = file.readUInt32BE(16);
  const height = file.readUInt32BE(20);
  const [depth, kind, , , interlaced] = file.subarray(24, 29);
  const channels = { 2: 3, 6: 4 }[kind];
  if (depth !== 8 || interlaced !== 0 || channels === undefined) throw new Error("this PNG is of another kind");

  const parts = [];
  for (let at = 8; at < file.length; ) {
    const length = file.readUInt32BE(at);
    if (file.toString("latin1", at + 4, at + 8) === "IDAT") parts.push(file.subarray(at + 8, at + 8 + length));
    at += length + 12;
  }
  const raw = inflateSync(Buffer.concat(parts));
  const stride = width * channels;
  const rgb = new Uint8Array(width * height * 3);
  let above = new Uint8Array(stride);
  for (let y = 0; y < height; y += 1) {
    const start = y * (stride + 1);
    const row = unfiltered(raw[start], raw.subarray(start + 1, start + 1 + stride), above, channels);
    for (let x = 0; x < width; x += 1) {
      for (let c = 0; c < 3; c += 1) rgb[3 * (y * width + x) + c] = row[x * channels + c];
    }
    above = row;
  }
  return { width, height, rgb };
}

/** Undoes one of the five predictions of PNG. */
function unfiltered(filter, coded, above, channels) {
  const row = new Uint8Array(coded.length);
  for (let i = 0; i < row.length; i += 1) {
    const left = i < channels ? 0 : row[i - channels];
    const corner = i < channels ? 0 : above[i - channels];
    const guess = [0, left, above[i], (left + above[i]) >> 1, paeth(left, above[i], corner)][filter];
    row[i] = coded[i] + guess;
  }
  return row;
}

function paeth(left, above, corner) {
  const [a, b, c] = [left, above, corner].map((value) => Math.abs(left + above - corner - value));
  if (a <= b && a <= c) return left;
  return b <= c ? above : corner;
}

/** `{ colours, covered }`: how many colours there are, and which share of the picture is not the commonest one. */
export function variety({ rgb }) {
  const counts = new Map();
  for (let i = 0; i < rgb.length; i += 3) {
    const colour = (rgb[i] << 16) | (rgb[i + 1] << 8) | rgb[i + 2];
    counts.set(colour, (counts.get(colour) ?? 0) + 1);
  }
  const commonest = Math.max(...counts.values());
  return { colours: counts.size, covered: 1 - commonest / (rgb.length / 3) };
}

/** The mean difference of two pictures of one size, in steps of 255. */
export function difference(one, other) {
  if (one.width !== other.width || one.height !== other.height) throw new Error("the pictures differ in size");
  let sum = 0;
  for (let i = 0; i < one.rgb.length; i += 1) sum += Math.abs(one.rgb[i] - other.rgb[i]);
  return sum / one.rgb.length;
}
