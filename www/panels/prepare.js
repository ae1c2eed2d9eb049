// Tools that make other triangles of the surface: one row each, with its numbers and a button.

import { h, icon, write } from "../dom.js";
import { numberRow } from "./number.js";

/** `apply(tool, values)` starts one. */
export function preparePanel(apply) {
  const node = h("fieldset", { class: "tools-list", "aria-label": "Prepare", hidden: true });
  let rows = new Map();
  let fingerprint = "";
  let isBusy = false;
  /** The tool that was started last: where the focus goes on when it has done its work. */
  let begun = null;

  function toolRow({ id, label, help, params }) {
    const numbers = params.map((param) => ({ id: param.id, ...numberRow(param, param, () => {}) }));
    params.forEach((param, i) => numbers[i].show(param.default));
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
      row,
      button,
      recommend(text) {
        adviceLine.hidden = !text;
        row.classList.toggle("recommended", Boolean(text));
        write(advice, text ?? "");
      },
    };
  }

  function enable() {
    for (const { button } of rows.values()) button.disabled = isBusy;
  }

  return {
    /** The section. */
    node,
    /** Takes a `tools` event: what was set in a row stays while the tools themselves are the same. */
    show({ options }) {
      const print = JSON.stringify(options.map((tool) => ({ ...tool, advice: null })));
      if (print !== fingerprint) {
        fingerprint = print;
        rows = new Map(options.map((tool) => [tool.id, toolRow(tool)]));
        node.replaceChildren(h("legend", {}, "Prepare"), ...[...rows.values()].map(({ row }) => row));
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
