// The View menu of the surface: straight views from six sides, parallel lines of sight, one piece alone, clipping, measuring; and the
// two bars that clipping and measuring bring with them.

import { byId, h, icon, popover, write } from "../dom.js";
import { fixed } from "../format.js";

/** Sides, the keys that show them, and where they stand in the menu. */
const SIDES = [
  ["front", "Front", "1"],
  ["back", "Back", "Shift 1"],
  ["right", "Right", "3"],
  ["left", "Left", "Shift 3"],
  ["top", "Top", "7"],
  ["bottom", "Bottom", "Shift 7"],
];
const AXES = [["x", "x axis"], ["y", "y axis"], ["z", "z axis"], ["view", "View"]];

/**
 * @param on `side(id)`, `orthographic(isOn)`, `clip({ axis, kept, isTurned })`, `isolate()`, `measure(isOn)`, `clearMeasure()`, `keyboard()`,
 * `say(sentence)`
 */
export function viewMenu(on) {
  const button = byId("view-menu");
  const panel = byId("view-panel");
  const clipBar = byId("clip-tools");
  const measureBar = byId("measure-tools");
  const { show } = popover(button, panel, { opened: () => panel.querySelector("button").focus() });

  const act = (name, keys, click, pressed = null) =>
    h("button", { class: "item", "aria-label": name, title: keys ? `${name} (${keys})` : name, "aria-pressed": pressed, onclick: click }, h("span", {}, name), keys ? h("kbd", { "aria-hidden": "true" }, keys) : null);
  /** A button that stays pressed; gives `set(isOn)`. */
  function toggle(name, keys, change) {
    const node = act(name, keys, () => set(!isOn()), "false");
    const isOn = () => node.getAttribute("aria-pressed") === "true";
    const set = (next) => {
      if (next === isOn() || node.disabled) return;
      node.setAttribute("aria-pressed", String(next));
      change(next);
    };
    return { node, isOn, set };
  }

  const chosen = (run) => () => {
    show(false);
    run();
  };
  const look = (id, name) => {
    on.side(id);
    on.say(`${name} view${orthographic.isOn() ? ", orthographic" : ""}`);
  };
  const orthographic = toggle("Orthographic", "5", (isOn) => {
    on.orthographic(isOn);
    on.say(isOn ? "Orthographic: equal lengths look equal, near and far" : "Perspective");
  });
  const clip = toggle("Clip", "X", (isOn) => {
    clipBar.hidden = !isOn;
    tell();
  });
  const measure = toggle("Measure", "D", (isOn) => {
    measureBar.hidden = !isOn;
    on.measure(isOn);
    tellEnds(0);
  });
  const alone = act("Isolate piece", "I", chosen(() => on.isolate()), "false");
  panel.append(
    h("div", { class: "sides", role: "group", "aria-label": "Look from" }, ...SIDES.map(([id, name, keys]) => act(name, keys, chosen(() => look(id, name))))),
    orthographic.node,
    alone,
    clip.node,
    measure.node,
    act("Keyboard", "?", chosen(() => on.keyboard())),
  );
  panel.addEventListener("click", ({ target }) => {
    // What opens a bar of its own makes room for it.
    if ([clip.node, measure.node].includes(target.closest("button"))) show(false);
  });

  // Clipping.
  const axis = h("select", { "aria-label": "Clip across", title: "What the clipping plane is straight to", onchange: tell }, ...AXES.map(([value, name]) => h("option", { value }, name)));
  axis.value = "z";
  const amount = h("output", { class: "value" });
  const slider = h("input", { type: "range", min: "0", max: "1000", value: "500", "aria-label": "Clip at", oninput: tell });
  const other = h("button", {
    class: "act",
    "aria-pressed": "false",
    title: "Keeps the other side of the plane",
    onclick: () => {
      other.setAttribute("aria-pressed", String(other.getAttribute("aria-pressed") !== "true"));
      tell();
    },
  }, "Other side");
  const close = (name, what) => h("button", { class: "icon", "aria-label": name, title: `${name} (Esc)`, onclick: () => what.set(false) }, icon("close"));
  clipBar.append(
    h("span", { class: "pick" }, axis, icon("down")),
    h("label", { class: "amount" }, slider, amount),
    other,
    h("span", { class: "grow" }),
    close("End clipping", clip),
  );
  function tell() {
    const kept = Number(slider.value) / 1000;
    slider.style.setProperty("--v", `${100 * kept}%`);
    const text = `${fixed(100 * kept, 0)}\u00a0%`;
    write(amount, text);
    slider.setAttribute("aria-valuetext", `${text} kept`);
    on.clip({ axis: clip.isOn() ? axis.value : "none", kept, isTurned: other.getAttribute("aria-pressed") === "true" });
  }

  // Measuring.
  const said = h("p", { class: "say", "aria-live": "polite" });
  const again = h("button", { class: "act", title: "Begins anew", onclick: () => on.clearMeasure() }, "Clear");
  measureBar.append(said, h("span", { class: "grow" }), again, close("End measuring", measure));
  function tellEnds(count, result = null) {
    again.disabled = count === 0;
    if (result) write(said, result);
    else if (count < 2) write(said, count === 0 ? "Click two places; Enter sets one in the middle" : "Click the other end");
    said.title = said.textContent;
  }
  for (const [bar, what] of [[clipBar, clip], [measureBar, measure]]) {
    bar.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      event.stopPropagation();
      what.set(false);
      button.focus();
    });
  }

  return {
    look: (id) => look(id, SIDES.find(([other]) => other === id)[1]),
    toggleOrthographic: () => orthographic.set(!orthographic.isOn()),
    toggleClip: () => clip.set(!clip.isOn()),
    toggleMeasure: () => measure.set(!measure.isOn()),
    endMeasure: () => measure.set(false),
    isMeasuring: () => measure.isOn(),
    isClipping: () => clip.isOn(),
    endClip: () => clip.set(false),
    /** Says how far the measuring has come, or its result. */
    tellEnds,
    /** Which piece is shown alone, -1 for none. */
    isolated(patch) {
      alone.setAttribute("aria-pressed", String(patch >= 0));
      alone.title = patch >= 0 ? `Only piece ${patch + 1} is shown: brings all back (I)` : "Isolate piece (I): shows the piece alone that was pointed at last";
      button.classList.toggle("on", patch >= 0);
    },
    /** Takes the reason why nothing can be measured, null where it can. */
    block(reason) {
      if (reason !== null) measure.set(false);
      measure.node.disabled = reason !== null;
      measure.node.title = reason ?? "Measure (D): between two places, straight and along the surface";
    },
  };
}
