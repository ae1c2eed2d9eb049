// Tools that make other triangles of the surface: one row each, with its numbers and a button.

import { h, icon, write } from "../dom.js";
import { numberRow } from "./number.js";

/** `apply(tool, values)` starts one. */
export function preparePanel(apply) {
  const node = h("fieldset", { class: "tools-list", "aria-label": "Prepare", hidden: true });
  let rows = new Map();
  let isBusy = false;
  /** The tool that was started last: where the focus goes on when it has done its work. */
  let begun = null;

  /** `kept` are the values that a person has set, by parameter; the others begin at their defaults. */
  function toolRow({ id, label, help, params }, print, kept) {
    const set = new Map();
    const numbers = params.map((param) => {
      const number = numberRow(param, param, (value) => set.set(param.id, value));
      const value = kept.get(param.id);
      if (value >= param.min && value <= param.max) set.set(param.id, value);
      number.show(set.get(param.id) ?? param.default);
      return { id: param.id, ...number };
    });
    const values = () => Object.fromEntries(numbers.map((number) => [number.id, number.value()]));
    const button = h("button", { class: "act", "aria-description": help, title: help, onclick: begin }, "Apply");
    function begin() {
      begun = id;
      apply(id, values());
    }
    const advice = h("span");
    const adviceLine = h("p", { class: "advice", hidden: true }, icon("info"), advice);
    const row = h(
      "div",
      { class: "tool", role: "group", "aria-label": label },
      h("div", { class: "row", title: help }, h("span", {}, label), button),
      adviceLine,
      ...numbers.map(({ row }) => row),
    );
    return {
      print,
      set,
      row,
      button,
      recommend(text) {
        adviceLine.hidden = !text;
        row.classList.toggle("recommended", Boolean(text));
        write(advice, text ?? "");
      },
    };
  }

  /** The row of a tool, another one only where the tool has changed in more than its advice. */
  function renewed(tool) {
    const print = JSON.stringify({ ...tool, advice: null });
    const row = rows.get(tool.id);
    return row?.print === print ? row : toolRow(tool, print, row?.set ?? new Map());
  }

  function enable() {
    for (const { button } of rows.values()) button.disabled = isBusy;
  }

  return {
    /** The section. */
    node,
    /** Takes a `tools` event. What a person has set stays where the tool still allows it, also on another mesh. */
    show({ options }) {
      const before = [...rows.values()];
      rows = new Map(options.map((tool) => [tool.id, renewed(tool)]));
      const after = [...rows.values()];
      // Rows that stay are not touched: somebody may be typing in one.
      if (after.length !== before.length || after.some((row, i) => row !== before[i])) {
        node.replaceChildren(h("legend", {}, "Prepare"), ...after.map(({ row }) => row));
      }
      for (const { id, advice } of options) rows.get(id).recommend(advice);
      node.hidden = options.length === 0;
      enable();
    },
    busy(now) {
      isBusy = now;
      enable();
      if (isBusy) return;
      if (document.activeElement === document.body) rows.get(begun)?.button.focus({ preventScroll: true });
      begun = null;
    },
  };
}
