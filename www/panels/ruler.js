// A length of the pattern to compare with: the longest round one that fits beside the legend.

import { write } from "../dom.js";
import { roundBelow, roundText } from "../format.js";

const LONGEST_PX = 64;

export function ruler(host) {
  const [bar, text] = host.children;
  return {
    /** Takes the screen pixels of one unit of the layout and the pattern, which says what that unit is worth. */
    show(pixels, pattern) {
      const perUnit = pattern?.unit_length > 0 ? pixels / pattern.unit_length : 0;
      host.hidden = !(perUnit > 0 && perUnit < Infinity);
      if (host.hidden) return;
      const length = roundBelow(LONGEST_PX / perUnit);
      bar.style.width = `${(length * perUnit).toFixed(1)}px`;
      write(text, `${roundText(length)} ${pattern.unit}`);
    },
  };
}
