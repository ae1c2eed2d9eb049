// Learn: one step of the flow in stages, each with its formula beside its field on the user's own surface. The texts
// are in index.html; the numbers come from the engine's events.

import { byId, h, icon, roving, write } from "../dom.js";
import { wordsOf } from "../fields.js";
import { fixed, measure, short } from "../format.js";
import { linkWords } from "./glossary.js";
import { fitFormulas, papersOf, player, stageParameters } from "./learn-parts.js";

/** Longer side of a stage's little picture, in CSS pixels. */
const THUMBNAIL_PX = 48;
/** While the surface is turned its little picture follows at this pace. */
const COPY_MS = 250;
/** States in which another step changes nothing. */
const ENDS = ["converged", "stalled"];
/** In a lecture type is as large as a stage lets it be: the first of these sizes, in per cent, at which it is seen whole. Before type
 * becomes small, the numbers are left out. */
const SIZES = { full: [100, 92, 85, 80], bare: [92, 85, 80, 75, 70, 65, 60] };

/**
 * @param on `field(id)` shows a field, `step()` takes one step, `reset()` goes back to the start, `change(id, value)` sets a parameter,
 * `word(name)` opens the glossary, `wires(isOn)` shows the triangles, `plain(isOn)` leaves the texture out, `layout()` before the page is
 * rearranged, `picture(canvas)` copies the surface as it is drawn now
 * @param facts gives `{ name, step, state, points, rows, fields, current, field, scene, stages, figures }` as known now: `figures` are
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
  let method = "cutflow";
  let at = 0;
  let before = null;
  /** The scene that was copied last, and when. */
  let copied = { scene: null, at: 0 };

  /** The stages of a method. */
  function build(id, title) {
    method = id;
    at = 0;
    write(byId("learn-title"), title);
    lessons = all.filter(({ dataset }) => (dataset.method ?? "cutflow") === method);
    thumbnails = lessons.map(() => h("canvas", { width: 2 * THUMBNAIL_PX, height: 2 * THUMBNAIL_PX, "aria-hidden": "true" }));
    buttons = lessons.map(({ dataset: { title, brief } }, i) =>
      h("button", { onclick: () => byHand(i) }, h("i", { class: "thumb" }, icon("eye"), thumbnails[i]), h("b", {}, `${i + 1}\u2002${title}`), h("span", {}, brief)),
    );
    list.replaceChildren(...buttons.map((button) => h("li", {}, button)));
  }
  build("cutflow", "One step of the cut flow");
  roving(list, "button");
  byId("learn").addEventListener("click", () => (panel.hidden ? open() : close()));
  byId("learn-close").addEventListener("click", close);
  const [once, again, end, play, lecture] = ["learn-once", "learn-reset", "learn-end", "learn-play", "lecture"].map(byId);
  once.addEventListener("click", on.step);
  again.addEventListener("click", on.reset);
  byId("learn-words").addEventListener("click", () => on.word());
  lecture.addEventListener("click", () => lecturing(!("lecture" in root.dataset)));
  panel.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    if ("lecture" in root.dataset) lecturing(false);
    else close();
  });
  // Presenters turn pages with keys of their own.
  addEventListener("keydown", (event) => {
    const way = { ArrowLeft: -1, PageUp: -1, ArrowRight: 1, PageDown: 1 }[event.key];
    const isBusy = event.defaultPrevented || event.altKey || event.ctrlKey || event.metaKey || event.target.closest("input, select, textarea, [role=tab], dialog");
    if (!way || panel.hidden || isBusy) return;
    event.preventDefault();
    if (lessons[at + way]) byHand(at + way);
  });

  const parameters = stageParameters(on.change);
  const playing = player({
    next() {
      go((at + 1) % lessons.length);
      return at + 1 < lessons.length;
    },
    text: () => lesson.textContent,
    changed(isOn) {
      play.setAttribute("aria-pressed", String(isOn));
      play.querySelector("use").setAttribute("href", `#i-${isOn ? "pause" : "run"}`);
    },
  });
  play.addEventListener("click", playing.press);
  lesson.addEventListener("input", playing.stop);
  new ResizeObserver(fit).observe(lesson);

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
    playing.stop();
    lecturing(false);
    // Its controls have the names of those among the parameters.
    lesson.replaceChildren();
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

  function lecturing(isOn) {
    if (isOn) root.dataset.lecture = "";
    else delete root.dataset.lecture;
    lecture.setAttribute("aria-pressed", String(isOn));
    fit();
  }

  /** In a lecture a stage is seen whole: nobody scrolls a projector. Elsewhere its formulas fit the column. */
  function fit() {
    if (panel.hidden) return;
    if (!("lecture" in root.dataset)) {
      fitFormulas(lesson);
      return;
    }
    for (const [amount, sizes] of Object.entries(SIZES)) {
      lesson.dataset.amount = amount;
      for (const size of sizes) {
        lesson.style.setProperty("--fit", size / 100);
        if (lesson.scrollHeight <= lesson.clientHeight && lesson.scrollWidth <= lesson.clientWidth) return;
      }
    }
  }

  /** Turns to a stage, and leaves the turning to whoever did that. */
  function byHand(i) {
    playing.stop();
    if (lesson.contains(document.activeElement)) turnTo(i);
    else go(i);
  }

  function go(i) {
    at = i;
    buttons.forEach((button, k) => {
      if (k === i) button.parentElement.setAttribute("aria-current", "step");
      else button.parentElement.removeAttribute("aria-current");
    });
    buttons[i].parentElement.scrollIntoView({ block: "nearest", inline: "center" });
    const content = document.importNode(lessons[i], true);
    linkWords(content, on.word);
    const other = (k, name) =>
      lessons[k]
        ? h(
            "button",
            { class: k > i ? "btn primary" : "btn", onclick: () => byHand(k) },
            k < i ? icon(name) : null,
            lessons[k].dataset.title,
            k > i ? icon(name) : null,
          )
        : null;
    missing.hidden = fieldOf(i) !== undefined;
    lesson.replaceChildren(
      h("p", { class: "muted" }, `Stage ${i + 1} of ${lessons.length}`),
      ...content.children,
      parameters.node,
      numbers,
      missing,
      papersOf(method),
      h("p", { class: "nav" }, other(i - 1, "prev"), h("span", { class: "grow" }), other(i + 1, "next")),
    );
    parameters.build(lessons[i].dataset.parameters?.split(" ") ?? []);
    lesson.scrollTop = 0;
    on.wires("wires" in lessons[i].dataset);
    // Its own colours are what a field has to show here.
    on.plain((fieldOf(i) ?? "pieces") !== "pieces");
    on.field(fieldOf(i) ?? "pieces");
    update();
    fit();
  }

  /** The button that was pressed is gone: the focus goes on at its heir. */
  function turnTo(i) {
    const isNext = i > at;
    go(i);
    const nav = [...lesson.querySelectorAll(".nav button")];
    const heir = isNext ? nav.at(-1) : nav[0];
    (heir?.checkVisibility() ? heir : byId("learn-title")).focus({ preventScroll: true });
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
    showEnd(ENDS.includes(now.state));
    const body = numbers.querySelector("tbody");
    const rows = rowsOf(now);
    const isOther = body.childElementCount !== rows.length;
    while (body.childElementCount > rows.length) body.lastElementChild.remove();
    rows.forEach(([name, value], i) => {
      if (!body.children[i]) body.append(h("tr", {}, h("th", { scope: "row" }), h("td")));
      write(body.children[i].children[0], name);
      write(body.children[i].children[1], value);
    });
    numbers.hidden = rows.length === 0;
    if (isOther) fit();
  }

  /** Where no step is left to take, Reset stands in its place. */
  function showEnd(isOver) {
    if (again.hidden === !isOver) return;
    const isFocused = [once, again].includes(document.activeElement);
    once.hidden = isOver;
    again.hidden = end.hidden = !isOver;
    if (isFocused) (isOver ? again : once).focus();
  }

  return {
    update,
    /** Takes a `parameters` event. */
    parameters: parameters.take,
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
    setMethod(id, title) {
      close();
      build(id, title);
    },
    isOpen: () => !panel.hidden,
    /** Opens at a stage, counted from 1; the nearest one where there are fewer. */
    openAt(stage) {
      at = Math.min(Math.max(0, stage - 1), lessons.length - 1);
      open();
    },
  };
}
