// The parameter panel: every row is made from a ParamSpec of the engine. The page knows no parameter by name.

import { h, icon, roving, write } from "../dom.js";
import { dial, fixed, parse, plural } from "../format.js";

/** Positions of a slider's handle. */
const NOTCHES = 1000;
/** Up to this many letters in all, a choice is a row of buttons; beyond, a list. */
const SEGMENT_LETTERS = 22;

/** `w_H` is written with its index lowered. */
function symbolNodes(symbol) {
  const [base, index] = symbol.split("_");
  return h("i", {}, base, index ? h("sub", {}, index) : null);
}

function decimals(step) {
  return step > 0 ? Math.max(0, Math.min(6, Math.ceil(-Math.log10(step) - 1e-9))) : 3;
}

/** Between a number and the place of its handle, evenly or by ratio. */
function scale({ min, max, step, logarithmic, integer }) {
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

function numberRow(spec, range, change) {
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
    slider.style.setProperty("--v", `${(100 * slider.value) / NOTCHES}%`);
    if (value === shown) return;
    shown = value;
    print(value);
    change(value);
  }
  function commit() {
    const value = parse(input.value);
    if (Number.isFinite(value)) set(round(value));
    show(shown);
  }
  function show(value) {
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
  );
  return {
    row,
    // A control in use keeps what its user is doing; the engine's answer may be an older value.
    show: (value) => {
      if (slider.matches(":active") || (document.activeElement === input && input.value !== text(shown))) return;
      show(value);
    },
  };
}

function segmentRow(spec, options, change, isChips) {
  const buttons = options.map((option) =>
    h("button", { type: "button", role: "radio", "aria-checked": "false", "data-id": option.id }, option.label),
  );
  const group = h("span", { class: isChips ? "chips" : "seg", role: "radiogroup", "aria-label": spec.label }, ...buttons);
  const choose = (button) => {
    show(button.dataset.id);
    change(button.dataset.id);
  };
  group.addEventListener("click", ({ target }) => {
    const button = target.closest("[role=radio]");
    if (button && button.getAttribute("aria-checked") !== "true") choose(button);
  });
  roving(group, "[role=radio]", choose);
  function show(value) {
    for (const button of buttons) {
      const isOn = button.dataset.id === value;
      button.setAttribute("aria-checked", String(isOn));
      button.tabIndex = isOn ? 0 : -1;
    }
  }
  const row = isChips ? group : h("div", { class: "row", title: spec.help }, spec.label, group);
  return { row, show };
}

function choiceRow(spec, options, change) {
  if (spec.id === "preset") return segmentRow(spec, options, change, true);
  const letters = options.reduce((sum, { label }) => sum + label.length, spec.label.length / 2);
  if (options.length <= 3 && letters <= SEGMENT_LETTERS) return segmentRow(spec, options, change, false);
  const select = h(
    "select",
    { "aria-label": spec.label, "aria-description": spec.help, onchange: () => change(select.value) },
    ...options.map((option) => h("option", { value: option.id }, option.label)),
  );
  const row = h("label", { class: "row", title: spec.help }, spec.label, h("span", { class: "pick" }, select, icon("down")));
  return { row, show: (value) => (select.value = value) };
}

function switchRow(spec, change) {
  const box = h("input", {
    type: "checkbox",
    role: "switch",
    "aria-label": spec.label,
    "aria-description": spec.help,
    onchange: () => change(box.checked),
  });
  const row = h("label", { class: "row", title: spec.help }, h("span", {}, spec.label), box);
  return { row, show: (value) => (box.checked = value === true) };
}

function rowFor(spec, change) {
  const { kind } = spec;
  if (kind.number) return numberRow(spec, kind.number, change);
  if (kind.choice) return choiceRow(spec, kind.choice.options, change);
  return switchRow(spec, change);
}

/** The panel. `change(id, value)` is called while a slider moves. */
export function parametersPanel(host, change) {
  let specs = [];
  let fingerprint = "";
  let rows = new Map();

  function build() {
    rows = new Map(specs.map((spec) => [spec.id, { spec, ...rowFor(spec, (value) => change(spec.id, value)) }]));
    const groups = new Map();
    for (const entry of rows.values()) {
      const name = entry.spec.advanced ? null : entry.spec.group;
      groups.set(name, [...(groups.get(name) ?? []), entry]);
    }
    const sets = [];
    for (const [name, entries] of groups) {
      if (name === null) continue;
      // A group that opens with a choice of its own name needs no heading above it.
      const leads = entries[0].spec.label === name && entries[0].spec.kind.choice;
      if (leads) entries[0].row.classList.add("first");
      sets.push(h("fieldset", { "aria-label": name }, leads ? null : h("legend", {}, name), ...entries.map((e) => e.row)));
    }
    const advanced = groups.get(null);
    if (advanced) {
      const wasOpen = host.querySelector("details")?.open ?? false;
      sets.push(
        h(
          "details",
          { open: wasOpen },
          h("summary", {}, "Advanced", icon("down"), h("span", {}, plural(advanced.length, "setting"))),
          h("fieldset", { "aria-label": "Advanced" }, ...advanced.map((e) => e.row)),
        ),
      );
    }
    host.replaceChildren(...sets);
  }

  return {
    /** Takes a `parameters` event: rows are rebuilt only when the table itself has changed. */
    show(event) {
      const table = JSON.stringify(event.specs);
      if (table !== fingerprint) {
        fingerprint = table;
        specs = event.specs;
        build();
      }
      for (const { spec, row, show } of rows.values()) {
        if (spec.id in event.values) show(event.values[spec.id]);
        const rule = spec.visible_if;
        row.hidden = Boolean(rule) && !rule.one_of.includes(event.values[rule.id]);
      }
      for (const set of host.querySelectorAll("fieldset, details")) {
        set.hidden = [...set.querySelectorAll(".param, .row, .chips")].every((row) => row.hidden);
      }
      const seen = [...host.querySelectorAll("details .param, details .row")].filter((row) => !row.hidden).length;
      const counter = host.querySelector("summary span");
      if (counter) write(counter, plural(seen, "setting"));
    },
    /** The specs shown last. */
    specs: () => specs,
  };
}
