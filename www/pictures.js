// Pictures of the views: as large as a file wants them, and as small as a card shows them.

import { h } from "./dom.js";

/** The longer side of an exported picture has this many pixels at least. */
const PICTURE_PX = 1600;
/** A picture is searched for what is drawn in it at this size. */
const PROBE_PX = 320;
/** The longest side that every graphics backend can draw. */
const MOST_PX = 8192;

/** The part of a picture in which anything differs from its corner, with a margin: `[x, y, width, height]`; all of it if nothing does. */
function drawnPart(canvas) {
  const small = Math.min(1, PROBE_PX / Math.max(canvas.width, canvas.height));
  const [width, height] = [canvas.width, canvas.height].map((side) => Math.max(1, Math.round(side * small)));
  const context = h("canvas", { width, height }).getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0, width, height);
  const { data } = context.getImageData(0, 0, width, height);
  const differs = (at) => [0, 1, 2].some((i) => Math.abs(data[at + i] - data[i]) > 8);
  let [left, top, right, bottom] = [width, height, -1, -1];
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      if (!differs(4 * (y * width + x))) continue;
      [left, right] = [Math.min(left, x), Math.max(right, x)];
      [top, bottom] = [Math.min(top, y), Math.max(bottom, y)];
    }
  }
  if (right < 0) return [0, 0, canvas.width, canvas.height];
  const margin = 0.04 * Math.max(right - left, bottom - top) + 1;
  const [x, y] = [Math.max(0, left - margin), Math.max(0, top - margin)];
  const [endX, endY] = [Math.min(width, right + 1 + margin), Math.min(height, bottom + 1 + margin)];
  return [x, y, endX - x, endY - y].map((length) => length / small);
}

/** Copies a canvas, made larger by `draw(width, height, ratio)`: `{ copy, context }`, to be drawn on in pixels of the page. */
export function enlarged(canvas, scale, draw) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const longer = Math.max(width, height, 1);
  draw(width, height, Math.min(scale * Math.max(devicePixelRatio || 1, PICTURE_PX / longer), MOST_PX / longer));
  const copy = h("canvas", { width: canvas.width, height: canvas.height });
  const context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0);
  context.scale(canvas.width / width, canvas.height / height);
  return { copy, context };
}

/** Copies the middle of a canvas, a square, into another one. */
export function copySquare(canvas, copy) {
  const side = Math.min(canvas.width, canvas.height);
  const [x, y] = [(canvas.width - side) / 2, (canvas.height - side) / 2];
  copy.getContext("2d").drawImage(canvas, x, y, side, side, 0, 0, copy.width, copy.height);
}

/** A small copy of a canvas: all of what is drawn in it, or its middle, which fills the copy. */
export function reduced(canvas, width, height, isWhole) {
  const [x, y, w, d] = isWhole ? drawnPart(canvas) : [0, 0, canvas.width, canvas.height];
  const scale = (isWhole ? Math.min : Math.max)(width / w, height / d);
  const size = [w * scale, d * scale];
  const copy = h("canvas", { width, height });
  const context = copy.getContext("2d");
  context.imageSmoothingQuality = "high";
  context.drawImage(canvas, x, y, w, d, (width - size[0]) / 2, (height - size[1]) / 2, ...size);
  return copy;
}
