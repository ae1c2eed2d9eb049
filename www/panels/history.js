// The history by name: what was done, what was taken back, and a way to any point of it with one click.

import { byId, h, popover, roving } from "../dom.js";

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** @param go is called with `(changes, meshes)`: how many changes forth (or back, negative), and how many other meshes they pass */
export function historyPanel(go) {
  const button = byId("history");
  const panel = byId("history-pop");
  const list = panel.querySelector("ol");
  let told = { done: [], undone: [] };

  const { show } = popover(button, panel, {
    opened() {
      fill();
      list.querySelector("[aria-current] button").focus();
    },
  });
  roving(list, "button");

  /** Oldest first: what stood at the beginning, then what each change made of it. */
  function fill() {
    const { done, undone } = told;
    const changes = [...[...done].reverse(), ...undone];
    const here = done.length;
    const item = (i) => {
      const passed = i < here ? changes.slice(i, here) : changes.slice(here, i);
      const meshes = passed.filter((change) => change.is_other_mesh).length;
      const text = i === 0 ? "Start" : capital(changes[i - 1].label);
      const press = () => {
        show(false);
        if (i !== here) go(i - here, i < here ? -meshes : meshes);
      };
      return h(
        "li",
        { class: i > here ? "undone" : false, "aria-current": i === here ? "step" : false },
        h("button", { tabindex: i === here ? "0" : "-1", title: i > here ? "Taken back: click to make it again" : false, onclick: press }, text),
      );
    };
    list.replaceChildren(...Array.from({ length: changes.length + 1 }, (_, i) => item(i)));
    list.querySelector("[aria-current]").scrollIntoView({ block: "nearest" });
  }

  return {
    /** Takes a `history` event. */
    show({ done, undone }) {
      told = { done, undone };
      button.disabled = done.length + undone.length === 0;
      if (!panel.hidden) fill();
    },
  };
}
