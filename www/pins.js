// Labels over a view that stay with a point: pinned values, which a click removes, and the length that was measured.

import { h, write } from "./dom.js";

/** Room that a label wants to the right of its point and above it, in pixels; without it, it stands on the other side. */
const WIDTH = 84;
const HEIGHT = 30;

function placeAt(node, host, x, y) {
  node.classList.toggle("left", x > host.clientWidth - WIDTH);
  node.classList.toggle("below", y < HEIGHT);
  node.style.translate = `${x.toFixed(1)}px ${y.toFixed(1)}px`;
}

/** The labels of one view, in `host`; `remove(pin)` is called when one is clicked. */
export function pinLabels(host, remove) {
  const pins = new Map();
  const text = h("span");
  const length = h("p", { class: "pinned length", "aria-hidden": "true", hidden: true }, text);
  host.append(length);

  function make(pin) {
    const label = h("button", {
      onclick: () => remove(pin),
      // A press on a label is no press on the surface under it.
      onpointerdown: (event) => event.stopPropagation(),
      ondblclick: (event) => event.stopPropagation(),
    });
    const node = h("div", { class: "pinned" }, h("i", { "aria-hidden": "true" }), label);
    host.append(node);
    return { node, label };
  }

  return {
    /** Takes what the viewer says of pins, `[pin, x, y, value, is hidden]`, …, and how values are written: `{ name, value(number) }`. */
    show(numbers, words) {
      const shown = new Set();
      for (let i = 0; i + 4 < numbers.length; i += 5) {
        const [pin, x, y, value, isHidden] = numbers.slice(i, i + 5);
        shown.add(pin);
        if (!pins.has(pin)) pins.set(pin, make(pin));
        const { node, label } = pins.get(pin);
        const said = Number.isFinite(value) ? words.value(value) : "–";
        if (label.textContent !== said) {
          write(label, said);
          label.setAttribute("aria-label", `Pinned ${words.name}: ${said}. Remove`);
          label.title = `${words.name}: click removes the pin`;
        }
        node.classList.toggle("behind", isHidden === 1);
        placeAt(node, host, x, y);
      }
      for (const [pin, { node }] of pins) {
        if (shown.has(pin)) continue;
        node.remove();
        pins.delete(pin);
      }
    },
    /** Shows a length at `[x, y]`; nothing where either is missing. */
    showLength(at, said) {
      length.hidden = at.length < 2 || !said;
      if (length.hidden) return;
      write(text, said);
      placeAt(length, host, at[0], at[1]);
    },
  };
}
