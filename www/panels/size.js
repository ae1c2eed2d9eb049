// The real size of the model: what a unit of the file is, and three linked boxes. The engine keeps the proportions.

import { h, icon } from "../dom.js";
import { fixed, parse } from "../format.js";

const SIDES = ["Width (x)", "Height (y)", "Depth (z)"];

/** Five digits, so that a metre is told to the tenth of a millimetre, without zeros that say nothing. */
function length(value) {
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size < 1e-4) return value.toExponential(3);
  const decimals = Math.max(0, Math.min(8, 4 - Math.floor(Math.log10(size))));
  const text = fixed(value, decimals);
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

/** In three digits, to be read at a glance. */
const brief = (value) => length(Number(value.toPrecision(3)));

/** `84.3 × 40 × 62.1 mm` */
export const sizeText = ({ boxes, display_unit }) => `${boxes.map(brief).join(" × ")}\u00a0${display_unit}`;

/** `on.setUnit(id)` and `on.setSize(axis, value)` resolve when the engine has answered. */
export function sizePanel(on) {
  let shown = null;
  const unit = h("select", { "aria-label": "Unit" });
  const unitRow = h(
    "label",
    { class: "row", title: "What one unit of the file is" },
    h("span", {}, "Unit of the file"),
    h("span", { class: "pick" }, unit, icon("down")),
  );
  const problem = h("p", { class: "problem", "aria-live": "polite" });
  const file = h("p", { class: "fine" });
  const sides = SIDES.map(sideRow);
  const node = h(
    "fieldset",
    { "aria-label": "Size", hidden: true },
    h("legend", {}, "Size"),
    ...sides.map(({ row }) => row),
    problem,
    unitRow,
    file,
  );
  unit.addEventListener("change", async () => {
    await on.setUnit(unit.value);
    // A unit that is refused is not the one shown.
    if (shown) unit.value = shown.unit;
  });

  function sideRow(label, axis) {
    let sent = NaN;
    let printed = "";
    const input = h("input", {
      "aria-label": label,
      inputmode: "decimal",
      autocomplete: "off",
      spellcheck: "false",
      onfocus: () => input.select(),
      onchange: commit,
      onblur: commit,
      onkeydown: (event) => {
        if (event.key === "Enter") commit();
        if (event.key === "Escape") print();
      },
    });
    const name = h("span");
    async function commit() {
      if (!shown || input.value === length(shown.boxes[axis])) return;
      const value = parse(input.value);
      if (!(value > 0 && value < Infinity)) {
        const kept = `${length(shown.boxes[axis])}\u00a0${shown.display_unit}`;
        problem.textContent = `${label} must be a number above 0, such as 120 or 12.5. It is ${kept} as before.`;
        print();
        return;
      }
      // Enter is followed by a change of the same value.
      if (value === sent) return;
      problem.textContent = "";
      sent = value;
      await on.setSize(axis, value);
      sent = NaN;
      print();
    }
    function print() {
      if (!shown) return;
      printed = length(shown.boxes[axis]);
      input.value = printed;
    }
    return {
      row: h("label", { class: "row" }, label, h("span", { class: "num" }, input, name)),
      show() {
        const isFlat = !(shown.boxes[axis] > 0);
        input.disabled = isFlat;
        input.title = isFlat ? "The model is flat along this axis" : "The other two sides follow";
        name.textContent = shown.display_unit;
        // Who is typing here is not interrupted by an older answer.
        if (!Number.isNaN(sent) || document.activeElement !== input || input.value === printed) print();
      },
    };
  }

  return {
    node,
    /** Takes a `size` event. */
    show(event) {
      const units = JSON.stringify(event.units);
      if (unit.dataset.units !== units) {
        unit.dataset.units = units;
        unit.replaceChildren(...event.units.map(({ id, label }) => h("option", { value: id }, label)));
      }
      shown = event;
      unit.value = event.unit;
      problem.textContent = "";
      for (const side of sides) side.show();
      const given = event.file.map(length).join(" × ");
      file.textContent = event.is_assumed
        ? `In the file ${given}, without a unit: this size is assumed. Give a side or a unit.`
        : `In the file ${given}. Proportions are kept.`;
      node.hidden = false;
    },
    hide() {
      shown = null;
      node.hidden = true;
    },
  };
}
