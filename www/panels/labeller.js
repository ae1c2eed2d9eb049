// Texts beside the points of a drawing, none over another.

import { s } from "../dom.js";

const [LETTER, MARGINS, HEIGHT] = [6.6, 4, 14];

/**
 * Gives `label(x, y, text, kind)`, which adds a text to `nodes` beside a point, between `left` and `right` and above `floor`, where no
 * earlier one stands. Where there is no room a `small` one is left out.
 */
export function labeller(nodes, left, right, floor) {
  const taken = [];
  const isFree = (box) => !taken.some((other) => box.x < other.x + other.w && other.x < box.x + box.w && box.y < other.y + HEIGHT && other.y < box.y + HEIGHT);
  return (x, y, text, kind) => {
    const w = text.length * LETTER + MARGINS;
    const sides = [[x + 8, y - 14], [x + 8, y - 7], [x + 8, y + 2], [x - 8 - w, y - 14], [x - 8 - w, y + 2]];
    const boxes = sides.map(([at, up]) => ({ x: at, y: up, w })).filter((box) => box.x >= left && box.x + w <= right && box.y >= 0 && box.y + HEIGHT <= floor);
    const box = boxes.find(isFree) ?? (kind === "small" ? undefined : boxes[0]);
    if (!box) return;
    taken.push(box);
    nodes.push(s("text", { class: kind, x: box.x + 2, y: box.y + 11 }, text));
  };
}
