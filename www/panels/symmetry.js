// The symmetries of the surface: found on request, then chosen one by one.

import { h, write } from "../dom.js";
import { percent } from "../format.js";

/** What stands above the list, by what the method uses symmetries for. */
const WORDS = {
  cut: {
    before: "Mirror planes and axes of the surface, which the cut can be made to have too.",
    none: "None found: no mirror plane or axis takes this surface to itself.",
    found: "The cut is made to have those that are ticked.",
  },
  patches: {
    before: "Mirror planes and half turns of the surface: pieces can be merged in both images of one of them, or in neither.",
    none: "None found: no mirror plane or half turn takes this surface to itself.",
    found: "Tick one, and pieces are merged in both of its images or in neither.",
  },
  pairs: {
    before: "Mirror planes of the surface: the table then names each cone's partner.",
    none: "None found: no mirror plane takes this surface to itself.",
    found: "The table of cones names the partners.",
  },
};

/** `on.find()` searches, `on.choose(ids)` says which of them cut or pieces are to have; both resolve when answered. */
export function symmetryPanel(on) {
  const line = h("p", { class: "fine", "aria-live": "polite" });
  const button = h("button", { class: "act", onclick: find }, "Find symmetries");
  const list = h("ul", { class: "symmetries", "aria-label": "Symmetries", hidden: true });
  const node = h("div", { class: "symmetry", hidden: true }, line, list, button);
  let boxes = new Map();
  let fingerprint = "";
  let isSearching = false;
  let isSingle = false;

  async function find() {
    isSearching = true;
    button.disabled = true;
    write(button, "Looking …");
    await on.find();
    rest();
  }

  function rest() {
    isSearching = false;
    button.disabled = false;
    write(button, boxes.size > 0 ? "Search again" : "Find symmetries");
    // The button was off while it worked and has lost the focus.
    if (document.activeElement === document.body) button.focus({ preventScroll: true });
  }

  /** Where there is one at a time, the one that was ticked last. */
  function chosen(last) {
    const ticked = [...boxes].filter(([, box]) => box.checked).map(([id]) => id);
    return isSingle ? ticked.filter((id) => id === last) : ticked;
  }

  function row({ id, label, deviation }) {
    const box = h("input", { type: "checkbox", onchange: () => on.choose(chosen(id)) });
    boxes.set(id, box);
    const title = `The surface differs from its image by up to ${percent(deviation)} of its size.`;
    return h("li", {}, h("label", { title }, box, h("span", {}, label), h("span", { class: "muted" }, `off by ${percent(deviation)}`)));
  }

  function sentence({ serves, is_searched: isSearched, options }) {
    const words = WORDS[serves] ?? WORDS.cut;
    if (!isSearched) return words.before;
    return options.length === 0 ? words.none : words.found;
  }

  return {
    node,
    /** Takes a `symmetries` event. */
    show(event) {
      isSingle = event.serves === "patches";
      const print = JSON.stringify([event.serves, ...event.options.map(({ id, label, deviation }) => [id, label, deviation])]);
      if (print !== fingerprint) {
        fingerprint = print;
        boxes = new Map();
        list.replaceChildren(...event.options.map(row));
        for (const box of boxes.values()) box.hidden = event.serves === "pairs";
      }
      for (const { id, on: isOn } of event.options) boxes.get(id).checked = isOn;
      list.hidden = event.options.length === 0;
      write(line, sentence(event));
      node.hidden = event.serves === "nothing";
      if (!isSearching) write(button, boxes.size > 0 ? "Search again" : "Find symmetries");
    },
    /** Whoever waits for a lost engine waits no longer. */
    rest,
  };
}
