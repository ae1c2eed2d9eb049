// What went wrong, where, and what to do about it; and the short notices that pass by themselves.

import { byId, h, icon, write } from "../dom.js";

/** Long enough to read a sentence twice. */
const TOAST_MS = 6000;

/** `dismissed()` is called when the person has read it. */
export function errorPanel(dismissed) {
  const host = byId("error");
  let isRefusal = false;
  return {
    /** Takes an `error` event; a refusal is about a document and goes when another one is opened. */
    show({ what, where, what_to_do }, refusal = false) {
      isRefusal = refusal;
      const close = h(
        "button",
        {
          class: "icon",
          "aria-label": "Dismiss",
          title: "Dismiss (Esc)",
          onclick: () => {
            host.hidden = true;
            dismissed();
          },
        },
        icon("close"),
      );
      host.replaceChildren(
        icon("alert"),
        h(
          "div",
          {},
          h("p", { class: "what" }, what),
          where ? h("p", { class: "where" }, where) : null,
          what_to_do ? h("p", { class: "todo" }, what_to_do) : null,
        ),
        close,
      );
      host.hidden = false;
    },
    hideRefusal() {
      if (isRefusal) host.hidden = true;
    },
    /** Dismisses what is shown; false if there was nothing. */
    dismiss() {
      if (host.hidden) return false;
      host.querySelector("button").click();
      return true;
    },
  };
}

/** One sentence that goes away again. */
export function toast() {
  const host = byId("toast");
  let timer = 0;
  return (sentence) => {
    clearTimeout(timer);
    host.textContent = sentence;
    host.hidden = false;
    timer = setTimeout(() => (host.hidden = true), TOAST_MS);
  };
}

/** A strip with a way out, shown when something takes longer than a moment. */
export function waitStrip() {
  const PATIENCE_MS = 200;
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
    begin(sentence, stop) {
      strip.end();
      const mine = turn;
      const isOn = () => mine === turn;
      cancel = stop;
      tell(sentence, null);
      timer = setTimeout(() => (host.hidden = false), PATIENCE_MS);
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
