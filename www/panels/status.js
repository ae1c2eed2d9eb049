// Transport buttons, the status line, and what a step costs.

import { byId, paced, write } from "../dom.js";
import { fixed } from "../format.js";

const INTERVAL = 125;
/** States from which a run can go on, and from which a single step can be taken. */
const STARTABLE = ["ready", "paused", "converged", "stalled", "step_limit"];

export function statusPanel({ run, pause, step, reset }) {
  const line = byId("status");
  const note = byId("note");
  const buttons = { run: byId("run"), pause: byId("pause"), step: byId("step"), reset: byId("reset") };
  let state = "loading";
  let text = line.textContent;
  let at = 0;
  let atRest = null;
  /** Why nothing can be run, null where it can. */
  let blocked = null;
  let energy = { start: null, now: null };
  let pace = { steps: 0, spent: 0 };
  /** Figures of the method in place of the energy's. */
  let figures = null;

  const titles = new Map(Object.values(buttons).map((button) => [button, button.title]));

  buttons.run.addEventListener("click", run);
  buttons.pause.addEventListener("click", pause);
  buttons.step.addEventListener("click", step);
  buttons.reset.addEventListener("click", reset);

  // A counter read aloud eight times a second would drown everything: only changes of state are announced.
  const count = paced(INTERVAL, () => {
    if (state === "running" && line.dataset.state === "running") line.setAttribute("aria-live", "off");
    else line.setAttribute("aria-live", "polite");
    line.dataset.state = state;
    write(line, text);
    line.title = text;
    write(note, summary());
  });

  function summary() {
    const parts = [];
    if (pace.steps > 0) parts.push(`${fixed(pace.spent / pace.steps, pace.spent / pace.steps < 10 ? 1 : 0)} ms per step`);
    if (figures !== null) parts.push(figures);
    else if (energy.start > 0 && energy.now >= 0 && energy.now < energy.start) {
      parts.push(`J down ${fixed(100 * (1 - energy.now / energy.start), 1)} %`);
    }
    return parts.join(", ");
  }

  /** A mesh that is ready and was not cut has no energy yet. */
  const isUncut = () => state === "ready" && energy.start === null;

  function enable() {
    // After an error the last good cut is still there.
    const canStart = (STARTABLE.includes(state) || (state === "error" && (energy.start !== null || figures !== null))) && blocked === null;
    // A button that the keyboard stands on hands the focus to the one that takes its place.
    const focused = document.activeElement;
    buttons.run.disabled = !canStart;
    buttons.pause.disabled = state !== "running";
    buttons.step.disabled = !canStart;
    // The start of a mesh that was not cut is still to be made.
    const isAtStart = state === "ready" && at === 0 && !isUncut();
    buttons.reset.disabled = isAtStart || !(canStart || (state === "running" && blocked === null));
    for (const [button, title] of titles) button.title = blocked ?? title;
    if (focused === buttons.run && state === "running") buttons.pause.focus();
    if (focused === buttons.pause && canStart) buttons.run.focus();
  }
  enable();

  return {
    /** Takes a `status` event. */
    show(event) {
      const changed = event.state !== state;
      state = event.state;
      at = event.step ?? 0;
      if (STARTABLE.includes(state)) atRest = event;
      text = event.text;
      document.documentElement.dataset.state = state;
      enable();
      if (changed) line.dataset.state = "";
      count();
    },
    /** Takes what is said in place of how the energy fell; null for nothing. */
    figures(text) {
      figures = text;
      count();
    },
    /** Takes the reason why the mesh cannot be cut yet, null where it can. */
    block(reason) {
      blocked = reason;
      enable();
    },
    /** Back to what was shown before an error, where nothing else has come since. */
    recover() {
      if (state === "error" && atRest) this.show(atRest);
    },
    state: () => state,
    isUncut,
    step: () => at,
    /** Another mesh: its energies are yet to come. */
    clear() {
      energy = { start: null, now: null };
      pace = { steps: 0, spent: 0 };
      count();
    },
    /** Takes an `energy` event. */
    energy(point) {
      if (point.step === 0 || energy.start === null) {
        energy = { start: point.total, now: point.total };
        pace = { steps: 0, spent: 0 };
        enable();
      } else {
        energy.now = point.total;
      }
      count();
    },
    /** Milliseconds that the engine spent, and the steps that came of it. */
    spent(milliseconds, steps) {
      pace.spent += milliseconds;
      pace.steps += steps;
    },
  };
}
