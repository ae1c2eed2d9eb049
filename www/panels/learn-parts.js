// Parts of Learn beside the lesson itself: the parameters of a stage, the papers, and the pace at which stages are played.

import { h, icon } from "../dom.js";
import { PAPERS } from "../papers.js";
import { parameterRow } from "./parameters.js";

/** What a stage is shown for while they are played: a pause, and time to read each word. */
const PAUSE_MS = 4000;
const WORD_MS = 130;

/** The parameters that a stage names, as the parameter panel has them. `change(id, value)` is called while one moves. */
export function stageParameters(change) {
  const node = h("fieldset", { class: "try", "aria-label": "Parameters of this stage" });
  let specs = [];
  let values = {};
  let rows = [];
  let ids = [];

  function show() {
    for (const row of rows) row.show(values);
    node.hidden = rows.every(({ row }) => row.hidden);
  }

  function build(wanted) {
    ids = wanted;
    rows = ids.flatMap((id) => specs.filter((spec) => spec.id === id)).map((spec) => parameterRow(spec, (value) => change(spec.id, value)));
    node.replaceChildren(h("legend", {}, "Try it"), ...rows.map(({ row }) => row));
    show();
  }

  return {
    node,
    /** Shows these parameters; those that the method does not have are left out. */
    build,
    /** Takes a `parameters` event. */
    take(event) {
      const isNew = JSON.stringify(event.specs) !== JSON.stringify(specs);
      ({ specs, values } = event);
      if (isNew && node.isConnected) build(ids);
      else show();
    },
  };
}

/** Formulas are set this much smaller at most. */
const NARROWEST = 0.6;

/** Sets formulas as large as their column lets them be. */
export function fitFormulas(lesson) {
  for (const formula of lesson.querySelectorAll("math[display=block]")) {
    let narrow = 1;
    // Spaces and letters do not shrink quite alike: what is still too wide shrinks again.
    for (let turn = 0; turn < 3; turn += 1) {
      formula.style.setProperty("--narrow", narrow);
      const { paddingLeft, paddingRight } = getComputedStyle(formula);
      const { left, width: box } = formula.getBoundingClientRect();
      const room = box - Number.parseFloat(paddingLeft) - Number.parseFloat(paddingRight);
      // Rows end with their box; what overflows is told by their parts only.
      const ends = [...formula.querySelectorAll("*")].map((part) => part.getBoundingClientRect().right);
      const width = Math.max(...ends) - left - Number.parseFloat(paddingLeft);
      if (width <= room) break;
      narrow = Math.max(NARROWEST, (0.98 * narrow * room) / width);
    }
    formula.style.setProperty("--narrow", narrow);
  }
}

/** The papers behind a method; nothing is asked of the network until somebody follows a link. */
export function papersOf(method) {
  const item = ({ authors, title, where, doi }) => {
    const name = doi
      ? h("a", { href: `https://doi.org/${doi}`, target: "_blank", rel: "noopener", title: `doi:${doi}, opens in a new tab` }, title, icon("away"))
      : h("cite", {}, title);
    return h("li", {}, `${authors}: `, name, `, ${where}`);
  };
  return h("details", { class: "papers" }, h("summary", {}, "Papers", icon("down")), h("ul", {}, ...(PAPERS[method] ?? []).map(item)));
}

/**
 * Turns stages by itself. `next()` goes on by one and gives whether there is more, `text()` is what is read now, `changed(isOn)`
 * follows it. Who asked for reduced motion turns one stage with each press instead.
 */
export function player({ next, text, changed }) {
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  let timer = 0;

  const wait = () => {
    timer = setTimeout(() => (next() ? wait() : stop()), PAUSE_MS + WORD_MS * text().split(/\s+/).length);
  };
  function stop() {
    if (!timer) return;
    clearTimeout(timer);
    timer = 0;
    changed(false);
  }
  function press() {
    if (still.matches) next();
    else if (timer) stop();
    else {
      changed(true);
      wait();
    }
  }
  still.addEventListener("change", stop);
  return { press, stop };
}
