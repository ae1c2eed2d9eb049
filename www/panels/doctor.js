// The mesh doctor: what was found, where, and one button for each thing that can be done about it.

import { h, icon } from "../dom.js";
import { health } from "./mesh.js";

const SEVERITIES = {
  blocks: { icon: "block", name: "Must be repaired" },
  warning: { icon: "alert", name: "Warning" },
  note: { icon: "info", name: "Note" },
};
const ORDER = Object.keys(SEVERITIES);
/** Repairs of a finding that stand side by side; more are folded away. */
const SIDE_BY_SIDE = 3;

/** `on.repair(id)`, `on.repairAll()`, and `on.showFinding(id)`, null for the pieces. */
export function doctorPanel(on) {
  const headline = h("p", { class: "headline", tabindex: "-1" });
  const all = h("button", { class: "btn primary", onclick: on.repairAll }, "Repair all");
  const plan = h("ol", { class: "plan", "aria-label": "What Repair all does" });
  const list = h("ul", { class: "found", "aria-label": "Findings" });
  const legend = h("legend", {}, "Doctor");
  const node = h("fieldset", { "aria-label": "Doctor", hidden: true }, legend, headline, all, plan, list);
  let toggles = new Map();
  let fingerprint = "";
  let canRepair = false;
  let isBusy = false;
  let hadFocus = false;

  function repairButton({ id, label, help }, describedby) {
    const what = { class: "act", "data-repair": true, "aria-describedby": describedby, title: help };
    return h("button", { ...what, onclick: () => on.repair(id) }, label);
  }

  function row(finding) {
    const { id, severity, text, place, can_show, repairs } = finding;
    const { icon: shape, name } = SEVERITIES[severity] ?? SEVERITIES.note;
    const textId = `finding-${id}`;
    const actions = [];
    if (can_show) {
      const toggle = h(
        "button",
        {
          class: "act show",
          "aria-pressed": "false",
          "aria-describedby": textId,
          onclick: () => on.showFinding(toggle.getAttribute("aria-pressed") === "true" ? null : id),
        },
        icon("eye"),
        "Show me",
      );
      toggles.set(id, toggle);
      actions.push(toggle);
    }
    const isLong = repairs.length > SIDE_BY_SIDE;
    const beside = isLong ? repairs.slice(0, SIDE_BY_SIDE - 1) : repairs;
    actions.push(...beside.map((repair) => repairButton(repair, textId)));
    const rest = repairs.slice(beside.length);
    return h(
      "li",
      { class: severity },
      h("span", { role: "img", "aria-label": name, title: name }, icon(shape)),
      h(
        "div",
        {},
        h("p", { id: textId }, text),
        place ? h("p", { class: "fine" }, place) : null,
        actions.length > 0 ? h("div", { class: "acts" }, ...actions) : null,
        isLong
          ? h(
              "details",
              { class: "rest" },
              h("summary", {}, `${rest.length} other repairs`, icon("down")),
              h("div", { class: "acts" }, ...rest.map((repair) => repairButton(repair, textId))),
            )
          : null,
      ),
    );
  }

  function build(report) {
    toggles = new Map();
    const rank = ({ severity }) => ORDER.indexOf(severity);
    list.replaceChildren(...[...report.findings].sort((a, b) => rank(a) - rank(b)).map(row));
    list.hidden = report.findings.length === 0;
    const { id, icon: shape } = health(report);
    headline.className = `headline health ${id}`;
    headline.replaceChildren(icon(shape), h("span", {}, report.headline));
    canRepair = report.repair_all.length > 0;
    all.hidden = !canRepair && report.solvable;
    all.title = canRepair ? `Repair all: ${report.repair_all.join("; ")}` : "There is no repair for this";
    plan.hidden = !canRepair;
    plan.replaceChildren(...report.repair_all.map((label) => h("li", {}, label)));
  }

  function enable() {
    all.disabled = isBusy || !canRepair;
    for (const button of list.querySelectorAll("[data-repair]")) button.disabled = isBusy;
  }

  return {
    node,
    /** Takes a `doctor` event; rows are made anew only when the findings are others. */
    show(report) {
      const print = JSON.stringify({ ...report, shown: null });
      if (print !== fingerprint) {
        fingerprint = print;
        build(report);
      }
      for (const [id, toggle] of toggles) {
        const isShown = report.shown === id;
        toggle.setAttribute("aria-pressed", String(isShown));
        toggle.title = isShown ? "Back to the pieces" : "Mark it on the surface";
      }
      enable();
      node.hidden = false;
      // A button that has done its work is gone: whoever stood on it goes on at the verdict.
      if (hadFocus) headline.focus();
      hadFocus = false;
    },
    busy(now) {
      isBusy = now;
      enable();
    },
    hide() {
      hadFocus = node.contains(document.activeElement);
      node.hidden = true;
    },
  };
}
