// What went wrong, where, and what to do about it; and the short notices that pass by themselves.

import { byId, h, icon } from "../dom.js";

/** Long enough to read a sentence twice. */
const TOAST_MS = 6000;

/** `dismissed()` is called when the person has read it. */
export function errorPanel(dismissed) {
  const host = byId("error");
  let isRefusal = false;
  return {
    /** Takes an `error` event, maybe with an `action`, `{ label, run }`; a refusal is about a document and goes when another one is opened. */
    show({ what, where, what_to_do, action }, refusal = false) {
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
          action ? h("p", {}, h("button", { class: "act", onclick: action.run }, action.label)) : null,
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

/** One sentence that goes away again; null takes it away at once. */
export function toast() {
  const host = byId("toast");
  let timer = 0;
  return (sentence) => {
    clearTimeout(timer);
    host.hidden = sentence === null;
    if (sentence === null) return;
    host.textContent = sentence;
    timer = setTimeout(() => (host.hidden = true), TOAST_MS);
  };
}
