// What is waited for, with a way out where it takes long: answers to commands, and what the engine prepares by itself.

import { byId, write } from "../dom.js";

/** What takes no longer needs no word. */
const PATIENCE_MS = 200;

/** A strip with a way out, shown when something takes longer than a moment. */
function waitStrip() {
  const host = byId("wait");
  const [bar, text, button] = host.children;
  let timer = 0;
  let turn = 0;
  let cancel = () => {};
  button.addEventListener("click", () => {
    // One press is enough: what is asked to stop may need a moment for it.
    button.disabled = true;
    cancel();
  });

  /** What is done now and the part of it that is done, null where that is not known. */
  function tell(sentence, fraction) {
    write(text, sentence);
    bar.setAttribute("aria-label", sentence);
    if (Number.isFinite(fraction)) bar.value = fraction;
    else bar.removeAttribute("value");
  }

  const strip = {
    /**
     * Says what is waited for; `stop()` is called when a person does not want to wait. Gives this wait, whose methods
     * do nothing once it is over or another has taken its place.
     */
    begin(sentence, stop, patience = PATIENCE_MS) {
      strip.end();
      const mine = turn;
      const isOn = () => mine === turn;
      cancel = stop;
      tell(sentence, null);
      timer = setTimeout(() => (host.hidden = false), patience);
      return {
        isOn,
        progress: (sentence, fraction) => isOn() && tell(sentence, fraction),
        end: () => isOn() && strip.end(),
      };
    },
    /** Ends whatever is waited for. */
    end() {
      turn += 1;
      clearTimeout(timer);
      host.hidden = true;
      button.disabled = false;
    },
  };
  return strip;
}

/**
 * @param on `cancel(sentence)` ends the engine, `stop()` asks it to stop what it prepares, `mesh()` gives the open mesh,
 * `busy(isBusy)` is told when something begins and ends to be prepared
 */
export function waiting(on) {
  const strip = waitStrip();
  /** What is shown or was last: for the answer to a command, and for what is prepared. */
  let answer = null;
  let preparation = null;
  /** What the engine prepares, as a sentence; null where it prepares nothing. */
  let prepared = null;

  /** Shows what is prepared: once for each mesh, and not before an answer that is waited for. */
  function showPreparation() {
    if (prepared === null || answer?.isOn()) return;
    if (preparation?.isOn() && preparation.mesh === on.mesh()) return;
    preparation = { mesh: on.mesh(), ...strip.begin(prepared, on.stop) };
  }

  async function wait(sentence, ask, stop, patience) {
    const mine = strip.begin(sentence, stop, patience);
    answer = mine;
    const got = await ask();
    mine.end();
    showPreparation();
    return got;
  }

  const waits = {
    /** Waits for the answer to `ask()`; who does not want to wait for it gets a new engine. */
    answer: (sentence, cancelled, ask, patience) => wait(sentence, ask, () => on.cancel(cancelled), patience),
    /** The same where the engine goes on: `back()` is called, and the answer is of no interest any more. */
    ask: (sentence, ask, back) => wait(sentence, ask, () => (strip.end(), back())),
    /** Takes what is prepared now, null where nothing is. */
    prepare(sentence) {
      const hasChanged = (sentence === null) !== (prepared === null);
      prepared = sentence;
      if (hasChanged) on.busy(sentence !== null);
      if (sentence === null) preparation?.end();
      else showPreparation();
    },
    isPreparing: () => prepared !== null,
    progress: (label, fraction) => preparation?.progress(label, fraction),
    /** Shows nothing of what is waited for now. */
    hide: () => strip.end(),
    /** Nothing is waited for any more. */
    end() {
      waits.prepare(null);
      strip.end();
    },
  };
  return waits;
}
