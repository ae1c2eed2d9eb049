// Learn: one step of the running method, stage by stage, with its formulas beside its field on the person's own
// surface. The texts are in index.html; the numbers come from the engine's events.

import { byId, h, icon, write } from "../dom.js";
import { among, fixed, measure, short } from "../format.js";

/**
 * @param on `field(id)` shows a field, `step()` takes one step, `layout()` after the page was rearranged
 * @param facts gives `{ name, step, points, rows, fields, current }` as known now
 */
export function learnPanel(on, facts) {
  const root = document.documentElement;
  const panel = byId("learn-panel");
  const lesson = byId("lesson");
  const list = byId("stages");
  const lessons = [...byId("lessons").content.querySelectorAll("article")];
  let at = 0;
  let before = null;

  const buttons = lessons.map(({ dataset: { title, brief } }, i) => {
    const button = h("button", { onclick: () => go(i) }, h("b", {}, `${i + 1}\u2002${title}`), h("span", {}, brief));
    list.append(h("li", {}, button));
    return button;
  });
  byId("learn").addEventListener("click", () => (panel.hidden ? open() : close()));
  byId("learn-close").addEventListener("click", close);
  byId("learn-once").addEventListener("click", on.step);
  panel.addEventListener("keydown", (event) => {
    if (event.key === "Escape") close();
  });

  const numbers = h("table", {}, h("caption", {}, "On your surface"), h("tbody"));

  function open() {
    before = facts().current;
    panel.hidden = false;
    root.dataset.learn = "";
    on.layout();
    go(0);
    byId("learn-title").focus();
  }

  function close() {
    if (panel.hidden) return;
    panel.hidden = true;
    delete root.dataset.learn;
    on.layout();
    if (before !== null) on.field(before);
    byId("learn").focus();
  }

  /** The first overlay of the stage that the engine offers. */
  function fieldOf(i) {
    const offered = facts().fields.map((field) => field.id);
    return lessons[i].dataset.fields.split(" ").find((id) => offered.includes(id)) ?? "pieces";
  }

  function go(i) {
    at = i;
    buttons.forEach((button, k) => button.parentElement.toggleAttribute("aria-current", k === i));
    buttons[i].parentElement.setAttribute("aria-current", "step");
    const content = document.importNode(lessons[i], true);
    const other = (k, name) =>
      lessons[k]
        ? h(
            "button",
            { class: k > i ? "btn primary" : "btn", onclick: () => go(k) },
            k < i ? icon(name) : null,
            lessons[k].dataset.title,
            k > i ? icon(name) : null,
          )
        : null;
    lesson.replaceChildren(
      h("p", { class: "muted" }, `Stage ${i + 1} of ${lessons.length}`),
      ...content.children,
      numbers,
      h("p", { class: "nav" }, other(i - 1, "prev"), h("span", { class: "grow" }), other(i + 1, "next")),
    );
    lesson.scrollTop = 0;
    on.field(fieldOf(i));
    update();
  }

  function rowsOf({ points, rows, field }) {
    const last = points.at(-1);
    const previous = points.at(-2);
    const list = [];
    if (field && at !== 2) {
      const size = Math.max(...field.extremes.map(Math.abs));
      const [least, most, mean] = [...field.extremes, field.mean].map((value) => among(value, size));
      list.push([`${field.label}, least to most`, `${least} to ${most} ${field.unit}`]);
      list.push([`${field.label}, mean`, `${mean} ${field.unit}`]);
    }
    if (at >= 2 && last) {
      const change = (now, then) => (then === undefined ? short(now) : `${short(then)} → ${short(now)}`);
      list.push(["Energy J", change(last.total, previous?.total)]);
      if (at === 2) last.terms.forEach((term, i) => list.push([term.name, change(term.value, previous?.terms[i]?.value)]));
      if (at === 4 && previous) list.push(["Change in this step", short(last.total - previous.total)]);
    }
    if (at === 4 && points.length > 1) {
      list.push(["Change since the start", `${fixed(100 * (last.total / points[0].total - 1), 1)} %`]);
    }
    for (const row of rows) {
      if (at === 2 || at === 4 || row.id === "pieces") list.push([row.label, measure(row.now, row.unit)]);
    }
    return list;
  }

  function update() {
    if (panel.hidden) return;
    const now = facts();
    write(byId("learn-step"), `Step ${now.step} on ${now.name}`);
    const body = numbers.querySelector("tbody");
    const rows = rowsOf(now);
    while (body.childElementCount > rows.length) body.lastElementChild.remove();
    rows.forEach(([name, value], i) => {
      if (!body.children[i]) body.append(h("tr", {}, h("th", { scope: "row" }), h("td")));
      write(body.children[i].children[0], name);
      write(body.children[i].children[1], value);
    });
    numbers.hidden = rows.length === 0;
  }

  return { update, close, isOpen: () => !panel.hidden };
}
