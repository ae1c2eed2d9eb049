// The tool that adds cones: while it is held, a click on the surface or on a chart sets one.

import { byId, h } from "../dom.js";
import { parsePi } from "../format.js";

/** @param on `changed(isOn)`, `problem(sentence)` */
export function coneTool(on) {
  const button = byId("add-cone");
  const host = byId("cone-tools");
  let isOn = false;
  const angle = h("input", {
    "aria-label": "Angle of new cones",
    inputmode: "text",
    autocomplete: "off",
    spellcheck: "false",
    placeholder: "free",
    title: "In units of π: 0.5, -1/2, π/3. Empty leaves the angle to the optimum.",
    onkeydown: (event) => {
      if (event.key === "Enter") value();
      if (event.key === "Escape") put();
    },
  });
  host.append(
    h("label", { class: "newangle" }, h("span", {}, "Angle"), angle, h("span", {}, "π")),
    h("span", { class: "say" }, "Click where a cone is to be; Enter adds one in the middle"),
  );
  button.addEventListener("click", () => (isOn ? put() : hold()));

  /** The angle that is typed, null where it is left free, undefined where it makes no sense. */
  function value() {
    const text = angle.value.trim();
    if (text === "" || /^free$/i.test(text)) return null;
    const radians = parsePi(text);
    if (Number.isFinite(radians)) return radians;
    on.problem(`“${text}” is no angle. Write a number of π, such as 0.5, -1/2 or π/3, or nothing.`);
    return undefined;
  }

  function set(now) {
    if (isOn === now) return;
    isOn = now;
    const hadFocus = host.contains(document.activeElement);
    host.hidden = !isOn;
    button.setAttribute("aria-pressed", String(isOn));
    if (hadFocus && !isOn) button.focus();
    on.changed(isOn);
  }
  const hold = () => !button.hidden && !button.disabled && set(true);
  const put = () => set(false);

  return {
    /** Whether the method has cones. */
    offer(isOffered) {
      button.hidden = !isOffered;
      if (!isOffered) put();
    },
    /** Takes the reason why nothing can be added, null where it can. */
    block(reason) {
      button.disabled = reason !== null;
      button.title = reason ?? "Add cone (A): a click on the surface sets one";
      if (reason !== null) put();
    },
    isOn: () => isOn,
    toggle: () => (isOn ? put() : hold()),
    put,
    value,
  };
}
