// The angles beside the cones: text over the canvas at a constant size, the larger ones first, none over another.

import { s } from "./dom.js";
import { pi } from "./format.js";

/** A cone whose angle is a smaller part of the largest that is seen has no label unless it is pointed at. */
const SHARE = 0.2;
const MOST = 24;
/** Size of a label: its height, and what a letter and the margins take of its width. */
const HEIGHT = 16;
const LETTER = 6.3;
const MARGINS = 10;
/** Between a glyph with its rings and its label. */
const GAP = 5;

const overlap = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;

/**
 * Where labels go. `glyphs` are `{ cone, x, y, radius, text, size, isMarked }`, the most important first; gives
 * `{ cone, text, x, y, width, height }`, boxes inside a view of that size that cover neither each other nor a glyph.
 */
export function placeLabels(glyphs, width, height) {
  const largest = Math.max(...glyphs.map(({ size }) => size), 1e-12);
  const discs = glyphs.map(({ cone, x, y, radius }) => ({ cone, x: x - radius - 2, y: y - radius - 2, width: 2 * radius + 4, height: 2 * radius + 4 }));
  const placed = [];
  for (const { cone, x, y, radius, text, size, isMarked } of glyphs) {
    if (placed.length >= MOST) break;
    if (!isMarked && size < SHARE * largest) continue;
    if (placed.some((label) => label.cone === cone)) continue;
    const wide = text.length * LETTER + MARGINS;
    const off = radius + GAP;
    const places = [
      [x + off, y - HEIGHT / 2],
      [x - off - wide, y - HEIGHT / 2],
      [x - wide / 2, y - off - HEIGHT],
      [x - wide / 2, y + off],
    ];
    const boxes = places.map(([left, top]) => ({ cone, text, x: left, y: top, width: wide, height: HEIGHT }));
    const isFree = (box) =>
      box.x >= 0 && box.y >= 0 && box.x + wide <= width && box.y + HEIGHT <= height &&
      !placed.some((other) => overlap(box, other)) &&
      !discs.some((disc) => disc.cone !== cone && overlap(box, disc));
    const box = boxes.find(isFree) ?? (isMarked ? boxes[0] : undefined);
    if (box) placed.push(box);
  }
  return placed;
}

/** The labels of one view, in `host`. */
export function coneLabels(host) {
  const layer = s("svg", { class: "cone-labels", "aria-hidden": "true" });
  const labels = [];
  let boxes = [];
  host.append(layer);

  return {
    /** Takes what the viewer says of glyphs (`[cone, x, y, radius]`, …), the angles in radians, and the marked cones. */
    show(numbers, angles, marked) {
      const glyphs = [];
      for (let i = 0; i + 3 < numbers.length; i += 4) {
        const [cone, x, y, radius] = numbers.slice(i, i + 4);
        glyphs.push({ cone, x, y, radius, text: pi(angles[cone]), size: Math.abs(angles[cone]), isMarked: marked.includes(cone) });
      }
      boxes = placeLabels(glyphs, host.clientWidth, host.clientHeight);
      while (labels.length < boxes.length) {
        const [rect, text] = [s("rect", { height: HEIGHT, rx: 4 }), s("text", { y: HEIGHT / 2 })];
        const group = s("g", {}, rect, text);
        labels.push({ group, rect, text });
        layer.append(group);
      }
      labels.forEach(({ group, rect, text }, i) => {
        const box = boxes[i];
        group.toggleAttribute("hidden", !box);
        if (!box) return;
        group.setAttribute("transform", `translate(${box.x.toFixed(1)} ${box.y.toFixed(1)})`);
        rect.setAttribute("width", box.width);
        text.setAttribute("x", box.width / 2);
        if (text.textContent !== box.text) text.textContent = box.text;
      });
    },
    /** Draws them on a copy of the view. */
    write(context) {
      if (boxes.length === 0) return;
      const [ground, ink] = [labels[0].rect, labels[0].text].map((node) => getComputedStyle(node).fill);
      context.font = "600 11px system-ui, sans-serif";
      context.textAlign = "center";
      context.textBaseline = "middle";
      for (const { text, x, y, width, height } of boxes) {
        context.fillStyle = ground;
        context.beginPath();
        context.roundRect(x, y, width, height, 4);
        context.fill();
        context.fillStyle = ink;
        context.fillText(text, x + width / 2, y + height / 2);
      }
    },
  };
}
