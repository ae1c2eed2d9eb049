// The parameter panel: every row is made from a ParamSpec of the engine. The page knows no parameter by name.

import { h, icon, roving, write } from "../dom.js";
import { plural } from "../format.js";
import { numberRow } from "./number.js";

/** Up to this many letters in all, a choice is a row of buttons; beyond, a list. */
const SEGMENT_LETTERS = 22;

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

/** The group that the Mesh section shows in its own way. */
const SIZE = "Size";

/** The panel. `change(id, value)` is called while a slider moves. */
export function parametersPanel(host, change) {
  let specs = [];
  let fingerprint = "";
  let rows = new Map();

  function build() {
    const shown = specs.filter(({ group }) => group !== SIZE);
    rows = new Map(shown.map((spec) => [spec.id, { spec, ...rowFor(spec, (value) => change(spec.id, value)) }]));
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
