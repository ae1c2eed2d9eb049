// The parameter panel: every row is made from a ParamSpec of the engine. The page knows no parameter by name.

import { h, icon, roving, write } from "../dom.js";
import { plural } from "../format.js";
import { recall, remember } from "../storage.js";
import { numberRow } from "./number.js";

/** Up to this many letters in all, a choice is a row of buttons; beyond, a list. */
const SEGMENT_LETTERS = 22;
/** Groups that are open until somebody folds them: the first ones are what a cut is begun and judged by. */
const OPEN = 3;
/** The group that the Mesh section shows in its own way. */
const SIZE = "Size";
const ADVANCED = "Advanced";

function segmentRow(spec, options, change) {
  const buttons = options.map((option) =>
    h("button", { type: "button", role: "radio", "aria-checked": "false", "data-id": option.id }, option.label),
  );
  const group = h("span", { class: "seg", role: "radiogroup", "aria-label": spec.label, "aria-description": spec.help }, ...buttons);
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
  const row = h("div", { class: "row", title: spec.help }, h("span", { class: "rn" }, spec.label), group);
  return { row, show };
}

function choiceRow(spec, options, change) {
  const letters = options.reduce((sum, { label }) => sum + label.length, spec.label.length / 2);
  if (options.length <= 3 && letters <= SEGMENT_LETTERS) return segmentRow(spec, options, change);
  const select = h(
    "select",
    { "aria-label": spec.label, "aria-description": spec.help, onchange: () => change(select.value) },
    ...options.map((option) => h("option", { value: option.id }, option.label)),
  );
  const row = h(
    "label",
    { class: "row", title: spec.help },
    h("span", { class: "rn" }, spec.label),
    h("span", { class: "pick" }, select, icon("down")),
  );
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
  const row = h("label", { class: "row", title: spec.help }, h("span", { class: "rn" }, spec.label), box);
  return { row, show: (value) => (box.checked = value === true) };
}

/** A parameter's row: `{ spec, row, isChanged, text(value), show(values) }`; `change(value)` is called while it moves. */
export function parameterRow(spec, change) {
  const { show, ...entry } = { spec, isChanged: false, ...rowFor(spec, change) };
  const dot = changedDot(spec, entry.text, change);
  // A click on the text of a label is one on the first control in it: the dot comes last.
  entry.row.append(dot);
  entry.show = (values) => {
    const value = values[spec.id];
    if (spec.id in values) show(value);
    const rule = spec.visible_if;
    entry.row.hidden = Boolean(rule) && !rule.one_of.includes(String(values[rule.id]));
    entry.isChanged = spec.id in values && !isDefault(spec, value);
    // Whoever stands on the dot has pressed it: the row goes on.
    if (!entry.isChanged && document.activeElement === dot) entry.row.querySelector("input, select, [tabindex='0']")?.focus();
    dot.hidden = !entry.isChanged;
  };
  return entry;
}

function rowFor(spec, change) {
  const { kind } = spec;
  if (kind.number) return numberRow(spec, kind.number, change);
  if (kind.choice) {
    const { options } = kind.choice;
    return { text: (value) => options.find(({ id }) => id === value)?.label ?? value, ...choiceRow(spec, options, change) };
  }
  return { text: (value) => (value ? "on" : "off"), ...switchRow(spec, change) };
}

/** A dot beside what differs from its default; a click on it brings the default back. */
function changedDot(spec, text, change) {
  const title = `Changed. Back to ${text(spec.default)}${spec.unit ? ` ${spec.unit}` : ""}`;
  return h("button", {
    type: "button",
    class: "changed",
    "aria-label": `Reset ${spec.label} to ${text(spec.default)}`,
    title,
    hidden: true,
    onclick: (event) => {
      // It stands inside the label of a switch or a list.
      event.preventDefault();
      change(spec.default);
    },
  });
}

function grouped(entries, nameOf) {
  const groups = new Map();
  for (const entry of entries) {
    const name = nameOf(entry.spec);
    groups.set(name, [...(groups.get(name) ?? []), entry]);
  }
  return groups;
}

/** Numbers come back from the engine as they were sent, or rounded in their last digit. */
function isDefault({ default: usual }, value) {
  return typeof usual === "number" ? Math.abs(value - usual) <= 1e-9 * Math.abs(usual) : value === usual;
}

/**
 * The panel. `change(id, value)` is called while a slider moves; `extras` are nodes that belong to a group, by its name,
 * whether or not the engine has parameters for that group; `companions` are nodes that stand before a parameter's row, by
 * its identifier; `belongs(group)` says which groups are shown, `title(group)` what they are called.
 */
export function parametersPanel(host, change, extras = {}, companions = {}, belongs = (group) => group !== SIZE && !group.includes(": "), title = (group) => group) {
  let specs = [];
  let fingerprint = "";
  let rows = new Map();
  let sections = [];

  function section(name, isOpen, ...content) {
    const key = `group.${name}`;
    const counter = h("span");
    const summary = h("summary", {}, title(name), icon("down"), counter);
    const kept = recall(key);
    const node = h("details", { class: "group", open: kept === null ? isOpen : kept === "open" }, summary, ...content);
    // Only what a person does is remembered.
    summary.addEventListener("click", () => remember(key, node.open ? "closed" : "open"));
    return { name, node, counter };
  }

  function build() {
    const shown = specs.filter(({ group }) => belongs(group));
    rows = new Map();
    for (const spec of shown) rows.set(spec.id, parameterRow(spec, (value) => change(spec.id, value)));
    const groups = grouped(rows.values(), (spec) => (spec.advanced ? ADVANCED : spec.group));
    for (const name of Object.keys(extras)) if (!groups.has(name)) groups.set(name, []);
    const advanced = groups.get(ADVANCED) ?? [];
    groups.delete(ADVANCED);
    sections = [...groups].map(([name, entries], i) => {
      const content = entries.flatMap(({ spec, row }) => [companions[spec.id] ?? null, row]);
      const set = h("fieldset", { "aria-label": title(name) }, ...content, extras[name] ?? null);
      return { ...section(name, i < OPEN, set), entries, extra: extras[name] };
    });
    if (advanced.length > 0) {
      const parts = [...grouped(advanced, (spec) => spec.group)].map(([name, entries]) =>
        h("fieldset", { "aria-label": title(name) }, h("legend", { class: "sub" }, title(name)), ...entries.map(({ row }) => row)),
      );
      sections.push({ ...section(ADVANCED, false, ...parts), entries: advanced });
    }
    host.replaceChildren(...sections.map(({ node }) => node));
  }

  /** Hides what holds nothing, and says of each section what it holds. */
  function summarise() {
    for (const { name, node, counter, entries, extra } of sections) {
      const seen = entries.filter(({ row }) => !row.hidden);
      node.hidden = seen.length === 0 && (!extra || extra.hidden);
      for (const set of node.querySelectorAll("fieldset:has(> .sub)")) {
        set.hidden = [...set.querySelectorAll(".param, .row")].every((row) => row.hidden);
      }
      const changed = seen.filter(({ isChanged }) => isChanged).length;
      const text = changed > 0 ? `${changed} changed` : name === ADVANCED ? plural(seen.length, "setting") : "";
      write(counter, text);
    }
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
      for (const { show } of rows.values()) show(event.values);
      summarise();
    },
    /** After an extra was shown or hidden. */
    summarise,
    /** The specs shown last. */
    specs: () => specs,
  };
}
