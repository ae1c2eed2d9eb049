// Learn: one step of the flow in stages, each with its formula beside its field on the user's own surface. The texts
// are in index.html; the numbers come from the engine's events.

import { byId, h, icon, roving, write } from "../dom.js";
import { wordsOf } from "../fields.js";
import { fixed, measure, short } from "../format.js";

/** Longer side of a stage's little picture, in CSS pixels. */
const THUMBNAIL_PX = 48;
/** While the surface is turned its little picture follows at this pace. */
const COPY_MS = 250;

/**
 * @param on `field(id)` shows a field, `step()` takes one step, `wires(isOn)` shows the triangles, `plain(isOn)` leaves the
 * texture out, `layout()` before
 * the page is rearranged, `picture(canvas)` copies the surface as it is drawn now
 * @param facts gives `{ name, step, points, rows, fields, current, field, scene, stages, figures }` as known now: `figures` are
 * `[name, text]` of the method as a whole, for stages that ask for them with `data-figures`
 */
export function learnPanel(on, facts) {
  const root = document.documentElement;
  const panel = byId("learn-panel");
  const lesson = byId("lesson");
  const list = byId("stages");
  const all = [...byId("lessons").content.querySelectorAll("article")];
  let lessons = [];
  let thumbnails = [];
  let buttons = [];
  let at = 0;
  let before = null;
  /** The scene that was copied last, and when. */
  let copied = { scene: null, at: 0 };

  /** The stages of a method. */
  function build(method, title) {
    at = 0;
    write(byId("learn-title"), title);
    lessons = all.filter(({ dataset }) => (dataset.method ?? "cutflow") === method);
    thumbnails = lessons.map(() => h("canvas", { width: 2 * THUMBNAIL_PX, height: 2 * THUMBNAIL_PX, "aria-hidden": "true" }));
    buttons = lessons.map(({ dataset: { title, brief } }, i) =>
      h("button", { onclick: () => go(i) }, h("i", { class: "thumb" }, icon("eye"), thumbnails[i]), h("b", {}, `${i + 1}\u2002${title}`), h("span", {}, brief)),
    );
    list.replaceChildren(...buttons.map((button) => h("li", {}, button)));
  }
  build("cutflow", "One step of the cut flow");
  roving(list, "button");
  byId("learn").addEventListener("click", () => (panel.hidden ? open() : close()));
  byId("learn-close").addEventListener("click", close);
  byId("learn-once").addEventListener("click", on.step);
  panel.addEventListener("keydown", (event) => {
    if (event.key === "Escape") close();
  });

  const numbers = h("table", {}, h("caption", {}, "On your surface"), h("tbody"));
  const missing = h("p", { class: "fine" }, "This surface shows its pieces here: the field of this stage is not at hand.");

  function open() {
    on.layout();
    before = facts().current;
    panel.hidden = false;
    root.dataset.learn = "";
    go(at);
    byId("learn-title").focus();
  }

  function close() {
    if (panel.hidden) return;
    panel.hidden = true;
    delete root.dataset.learn;
    on.wires(false);
    on.plain(false);
    if (before !== null) on.field(before);
    byId("learn").focus();
  }

  /** The first overlay of the stage that the engine offers, undefined where it offers none. */
  function fieldOf(i) {
    const offered = facts().fields.map((field) => field.id);
    return lessons[i].dataset.fields.split(" ").find((id) => offered.includes(id));
  }

  function go(i) {
    at = i;
    buttons.forEach((button, k) => {
      if (k === i) button.parentElement.setAttribute("aria-current", "step");
      else button.parentElement.removeAttribute("aria-current");
    });
    buttons[i].parentElement.scrollIntoView({ block: "nearest", inline: "center" });
    const content = document.importNode(lessons[i], true);
    const other = (k, name) =>
      lessons[k]
        ? h(
            "button",
            { class: k > i ? "btn primary" : "btn", onclick: () => turnTo(k) },
            k < i ? icon(name) : null,
            lessons[k].dataset.title,
            k > i ? icon(name) : null,
          )
        : null;
    missing.hidden = fieldOf(i) !== undefined;
    lesson.replaceChildren(
      h("p", { class: "muted" }, `Stage ${i + 1} of ${lessons.length}`),
      ...content.children,
      numbers,
      missing,
      h("p", { class: "nav" }, other(i - 1, "prev"), h("span", { class: "grow" }), other(i + 1, "next")),
    );
    lesson.scrollTop = 0;
    on.wires("wires" in lessons[i].dataset);
    // Its own colours are what a field has to show here.
    on.plain((fieldOf(i) ?? "pieces") !== "pieces");
    on.field(fieldOf(i) ?? "pieces");
    update();
  }

  /** The button that was pressed is gone: the focus goes on at its heir. */
  function turnTo(i) {
    const isNext = i > at;
    go(i);
    const nav = [...lesson.querySelectorAll(".nav button")];
    (isNext ? nav.at(-1) : nav[0])?.focus({ preventScroll: true });
  }

  /** What the engine tells of the stage, else what its field and the energy tell. */
  function rowsOf({ points, rows, field, stages, figures }) {
    const { dataset } = lessons[at];
    const told = stages.find(({ id }) => id === dataset.id)?.numbers ?? [];
    if (told.length > 0) return told.map(({ label, value, unit }) => [label, measure(value, unit)]);
    const list = [];
    if (field && field.id === fieldOf(at)) {
      const words = wordsOf(field);
      const [least, most, mean] = [...field.extremes, field.mean].map(words.value);
      // What the values say themselves needs no unit behind them.
      const unit = words.unit === field.unit ? ` ${field.unit}` : "";
      list.push([`${words.label}, least to most`, `${least} to ${most}${unit}`]);
      list.push([`${words.label}, mean`, `${mean}${unit}`]);
    }
    if (dataset.figures !== undefined) return [...list, ...figures];
    if (!("check" in dataset)) return [...list, ...rows.filter(({ id }) => id === "pieces").map(({ label, now, unit }) => [label, measure(now, unit)])];
    const last = points.at(-1);
    const previous = points.at(-2);
    const change = (now, then) => (then === undefined ? short(now) : `${short(then)} → ${short(now)}`);
    if (last) {
      list.push(["Energy J", change(last.total, previous?.total)]);
      last.terms.forEach((term, i) => list.push([term.name, change(term.value, previous?.terms[i]?.value)]));
    }
    if (points.length > 1) list.push(["Change since the start", `${fixed(100 * (last.total / points[0].total - 1), 1)} %`]);
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

  return {
    update,
    /** After the surface was drawn: the stage keeps a little picture of it. */
    drawn() {
      if (panel.hidden) return;
      const { field, scene } = facts();
      const now = performance.now();
      const isRecent = scene === copied.scene && now - copied.at < COPY_MS;
      if (isRecent || (field?.id ?? "pieces") !== (fieldOf(at) ?? "pieces")) return;
      copied = { scene, at: now };
      on.picture(thumbnails[at]);
      thumbnails[at].dataset.drawn = "";
    },
    close,
    /** Takes another method, and what is said over its stages. */
    setMethod(method, title) {
      close();
      build(method, title);
    },
    isOpen: () => !panel.hidden,
    /** Opens at a stage, counted from 1; the nearest one where there are fewer. */
    openAt(stage) {
      at = Math.min(Math.max(0, stage - 1), lessons.length - 1);
      open();
    },
  };
}
