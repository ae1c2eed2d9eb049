// All keys of the page in one dialog.

import { byId, h, icon } from "../dom.js";

const GROUPS = [
  ["Work", [
    ["O", "Open a mesh"],
    ["Space", "Run, or pause"],
    [".", "One step"],
    ["R", "Reset"],
    ["Ctrl Z", "Undo"],
    ["Ctrl Shift Z", "Redo"],
    ["Esc", "Put the tool away, close, dismiss"],
    ["?", "These keys"],
  ]],
  ["Look", [
    ["1 · 3 · 7", "Front, right, top"],
    ["Shift 1 · 3 · 7", "Back, left, bottom"],
    ["5", "Orthographic or perspective"],
    ["I", "One piece alone, and back"],
    ["X", "Clip"],
    ["D", "Measure"],
    ["W", "Wireframe"],
    ["C", "Texture"],
    ["F", "Fit the view under the pointer"],
  ]],
  ["In a view that has the focus", [
    ["Arrows", "Turn the surface, move the charts"],
    ["Shift arrows", "Move"],
    ["+ · \u2212", "Closer, farther"],
    ["F · Home", "Fit"],
    ["Enter", "Set what the tool in hand sets, in the middle"],
  ]],
  ["In the table of pieces", [
    ["\u2191 · \u2193", "From piece to piece"],
    ["Enter", "Fly to the piece"],
    ["I", "The piece alone"],
  ]],
  ["Tools", [
    ["B", "Brush"],
    ["[ · ]", "Smaller, larger brush"],
    ["E", "Brush: erase"],
    ["A", "Add cones"],
    ["Delete", "Remove the chosen cone"],
    ["M", "Move the chosen cone to the middle"],
  ]],
  ["Mouse and fingers", [
    ["Drag", "Turns; with Shift, another button or two fingers it moves"],
    ["Wheel · pinch", "Closer, farther"],
    ["Click", "With a field shown: pins its value"],
    ["Double click", "Flies to the piece; beside it, fits"],
  ]],
];

/** Gives what opens the dialog. */
export function keyboardHelp() {
  let dialog = null;
  let before = null;
  function make() {
    const group = ([title, rows]) =>
      h("section", {}, h("h3", {}, title), h("dl", {}, ...rows.map(([keys, what]) => h("div", {}, h("dt", {}, ...keysOf(keys)), h("dd", {}, what)))));
    dialog = h(
      "dialog",
      { class: "keyboard", "aria-labelledby": "keyboard-title" },
      h("header", {}, h("h2", { id: "keyboard-title" }, "Keyboard"), h("span", { class: "grow" }),
        h("button", { class: "icon", "aria-label": "Close Keyboard", title: "Close (Esc)", onclick: () => dialog.close() }, icon("close"))),
      h("div", { class: "groups", tabindex: "0", "aria-label": "Keys", role: "group" }, ...GROUPS.map(group)),
    );
    // Keys meant for the dialog are none of the page's.
    dialog.addEventListener("keydown", (event) => event.stopPropagation());
    dialog.addEventListener("click", ({ target }) => target === dialog && dialog.close());
    dialog.addEventListener("close", () => before?.focus?.());
    document.body.append(dialog);
  }
  const keysOf = (keys) => keys.split(" · ").flatMap((part, i) => [i > 0 ? " · " : null, h("kbd", {}, part)]);
  return () => {
    if (!dialog) make();
    const active = document.activeElement;
    // The menu that it was opened from has closed.
    before = active && active !== document.body && active.checkVisibility() ? active : byId("view-menu");
    if (!dialog.open) dialog.showModal();
  };
}
