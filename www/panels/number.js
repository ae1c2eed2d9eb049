// A number with its slider, evenly or by ratio, as the parameters of methods and tools have it.

import { h, write } from "../dom.js";
import { dial, fixed, parse, trimmed } from "../format.js";

/** Positions of a slider's handle. */
export const NOTCHES = 1000;

/** `w_H` is written with its index lowered. */
function symbolNodes(symbol) {
  const [base, index] = symbol.split("_");
  return h("i", {}, base, index ? h("sub", {}, index) : null);
}

function decimals(step) {
  return step > 0 ? Math.max(0, Math.min(6, Math.ceil(-Math.log10(step) - 1e-9))) : 3;
}

/** Between a number and the place of its handle, evenly or by ratio. Notches go from 0 to `NOTCHES`. */
export function scale({ min, max, step, logarithmic, integer }) {
  const clamp = (value) => Math.min(max, Math.max(min, value));
  const round = (value) => clamp(integer ? Math.round(value) : value);
  if (!logarithmic) {
    const grid = step > 0 ? step : (max - min) / NOTCHES;
    return {
      text: (value) => (integer ? fixed(value, 0) : fixed(value, decimals(grid))),
      toNotch: (value) => (NOTCHES * (clamp(value) - min)) / (max - min),
      fromNotch: (notch) => round(min + Math.round(((notch / NOTCHES) * (max - min)) / grid) * grid),
      round,
    };
  }
  // A scale by ratio that begins at zero has zero as its first notch and starts again at the step.
  const floor = min > 0 ? min : step > 0 ? step : max / 1e4;
  const span = Math.log(max / floor);
  return {
    text: (value) => (integer ? fixed(value, 0) : dial(value, decimals(step))),
    toNotch: (value) => (value < floor ? 0 : (NOTCHES * Math.log(clamp(value) / floor)) / span),
    fromNotch: (notch) => {
      if (notch <= 0) return min;
      const value = floor * Math.exp((span * notch) / NOTCHES);
      return round(Number(value.toPrecision(2)));
    },
    round,
  };
}

/**
 * `{ row, text(value), show(value), value() }`: a number with its slider. `spec` names it (`label`, `symbol`, `unit`, `help`, `default`),
 * `range` bounds it (`min`, `max`, `step`, `logarithmic`, `integer`); `change(value)` is called while it moves.
 */
export function numberRow(spec, range, change) {
  const { text, toNotch, fromNotch, round } = scale(range);
  const unit = spec.unit ?? "";
  const input = h("input", {
    "aria-label": spec.label,
    "aria-description": spec.help,
    inputmode: "decimal",
    autocomplete: "off",
    spellcheck: "false",
    onchange: commit,
    onfocus: () => input.select(),
    onkeydown: (event) => {
      if (event.key === "Enter") commit();
      if (event.key === "Escape") show(shown);
    },
  });
  const slider = h("input", {
    type: "range",
    min: 0,
    max: NOTCHES,
    step: "any",
    "aria-label": `${spec.label} slider`,
    oninput: () => set(fromNotch(Number(slider.value))),
    onchange: () => show(shown),
    onkeydown: (event) => {
      // One press changes the value by one step at least.
      const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (!way) return;
      event.preventDefault();
      const next = range.integer || !range.logarithmic
        ? round(shown + way * (range.step || (range.integer ? 1 : (range.max - range.min) / 100)))
        : fromNotch(toNotch(shown) + way * 10);
      set(Number(next.toPrecision(10)));
      place(shown);
    },
  });
  const limit = h("p", { class: "fine", "aria-live": "polite" });
  let shown = spec.default;

  function print(value) {
    input.value = text(value);
    slider.setAttribute("aria-valuetext", `${text(value)} ${unit}`.trim());
  }
  function place(value) {
    slider.value = toNotch(value);
    slider.style.setProperty("--v", `${(100 * slider.value) / NOTCHES}%`);
  }
  function set(value) {
    if (value !== shown) write(limit, "");
    slider.style.setProperty("--v", `${(100 * slider.value) / NOTCHES}%`);
    if (value === shown) return;
    shown = value;
    print(value);
    change(value);
  }
  function commit() {
    // After Enter the browser tells of the same change once more.
    if (input.value === text(shown)) return;
    const value = parse(input.value);
    const isNumber = Number.isFinite(value);
    if (isNumber) set(round(value));
    show(shown);
    write(limit, isNumber ? beyond(value) : "");
  }
  /** Says of a number that was typed beyond the range where that ends, nothing of others. */
  function beyond(value) {
    const within = Math.min(range.max, Math.max(range.min, value));
    if (text(value) === text(within)) return "";
    return `${[trimmed(text(within)), unit].filter(Boolean).join(" ")} is the ${value > within ? "largest" : "smallest"} value here.`;
  }
  function show(value) {
    if (value !== shown) write(limit, "");
    shown = value;
    print(value);
    place(value);
  }
  const row = h(
    "div",
    { class: "param", title: spec.help },
    h("span", { class: "pn" }, spec.label, " ", spec.symbol ? symbolNodes(spec.symbol) : null),
    h("label", { class: "num" }, input, h("span", {}, unit)),
    slider,
    limit,
  );
  return {
    row,
    text,
    // A control in use keeps what its user is doing; the engine's answer may be an older value.
    show: (value) => {
      if (slider.matches(":active") || (document.activeElement === input && input.value !== text(shown))) return;
      show(value);
    },
    value: () => shown,
  };
}
