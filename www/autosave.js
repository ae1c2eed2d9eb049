// Keeps the project as it goes: in the memory of the page, from which a solver that died is brought back, and in the
// storage of the browser, from which the next visit is. The worker makes the file between two steps; nothing waits for it.

import { Refused, dropSession, holdSession, keepSession } from "./saved.js";

/** What changes at rest is kept this soon; a run is kept this often. */
const [REST_MS, RUN_MS] = [800, 5000];
/** Making the file may take one part in so many of the worker's time. */
const SHARE = 20;
/** Larger projects are not kept. */
const MOST_BYTES = 64 * 2 ** 20;

const WORDS = {
  denied: "This browser keeps no data of this page: the session ends with the tab. Export › Project (JSON) keeps it.",
  full: "There is no room left to keep the session in this browser. Export › Project (JSON) keeps it.",
  large: "The project is too large to be kept by itself. Export › Project (JSON) keeps it.",
};

/**
 * @param on `make()` asks for the project: `{ file, spent }`, `file` null where there is none; `say(sentence)`;
 * `about()` gives what is said of the document in an offer to restore it
 */
export function autosave(on) {
  const key = crypto.randomUUID?.() ?? String(Math.random());
  /** Whether the next visit may find it: not before somebody has done something. */
  let isStored = false;
  let isStoring = true;
  let isHeld = false;
  let isRunning = false;
  let isDirty = false;
  let isBusy = false;
  let isTooLarge = false;
  let timer = 0;
  let due = Infinity;
  let cost = 0;
  const said = new Set();

  function sayOnce(why) {
    if (said.has(why)) return;
    said.add(why);
    on.say(WORDS[why]);
  }

  function plan() {
    if (!isDirty || isBusy || isTooLarge) return;
    const at = performance.now() + Math.max(isRunning ? RUN_MS : REST_MS, SHARE * cost);
    // Changes that go on do not put it off.
    if (at >= due) return;
    clearTimeout(timer);
    due = at;
    timer = setTimeout(save, at - performance.now());
  }

  async function save() {
    clearTimeout(timer);
    due = Infinity;
    if (!isDirty || isBusy || isTooLarge) return;
    [isBusy, isDirty] = [true, false];
    const { file, spent } = await on.make();
    cost = spent ?? 0;
    if (file && file.bytes.length > MOST_BYTES) {
      isTooLarge = true;
      sayOnce("large");
    } else if (file && isStored && isStoring) {
      await store(file);
    }
    isBusy = false;
    plan();
  }

  async function store(file) {
    try {
      // Another tab must not take it for one that was left behind.
      if (!isHeld) holdSession(key);
      isHeld = true;
      await keepSession({ key, when: Date.now(), ...on.about(), bytes: file.bytes });
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      sayOnce(error.why);
      // What is denied stays denied; room may be made.
      if (error.why === "denied") isStoring = false;
      else dropSession(key).catch(() => {});
    }
  }

  // A tab that is left may never be heard of again.
  document.addEventListener("visibilitychange", () => document.visibilityState === "hidden" && save());

  return {
    /** Something has changed. */
    changed() {
      isDirty = true;
      plan();
    },
    /** Takes the state of the status line. */
    state(state) {
      const was = isRunning;
      isRunning = state === "running" || state === "preparing";
      if (was && !isRunning) plan();
    },
    /** From now on the next visit may find it. */
    store() {
      if (isStored) return;
      isStored = true;
      isDirty = true;
      plan();
    },
    /** Never in the storage: this page is a guest in another. */
    stayInMemory: () => (isStoring = false),
    /** Another mesh: it may be smaller. */
    renew: () => (isTooLarge = false),
    /** The worker that was asked is gone, and its answer with it. */
    forget() {
      isBusy = false;
      due = Infinity;
      plan();
    },
  };
}
