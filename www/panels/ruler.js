// A length of the pattern to compare with: the longest round one that fits beside the legend.

import { write } from "../dom.js";
import { count } from "../format.js";

const LONGEST_PX = 64;
const ROUND = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000];

export function ruler(host) {
  const [bar, text] = host.children;
  return {
    /** Takes the screen pixels of one unit of the layout and the pattern, which says what that unit is worth. */
    show(pixels, pattern) {
      const perUnit = pattern?.unit_length > 0 ? pixels / pattern.unit_length : 0;
      const length = ROUND.findLast((candidate) => candidate * perUnit <= LONGEST_PX);
      host.hidden = !(perUnit > 0) || length === undefined;
      if (host.hidden) return;
      bar.style.width = `${(length * perUnit).toFixed(1)}px`;
      write(text, `${count(length)} ${pattern.unit}`);
    },
  };
}
