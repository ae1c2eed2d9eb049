// The hierarchy of a phase field as a tree: each segment a button that shows it on the surface.

import { h, write } from "../dom.js";
import { measure, percent, plural, short } from "../format.js";

/** `select(node)` shows a segment, `handOver()` goes on with the cut flow. Gives a node that stands under the parameters of the segments. */
export function segmentsPanel(on) {
  const list = h("ul", { class: "segments", role: "tree", "aria-label": "Segments" });
  const line = h("p", { class: "fine" });
  const improve = h("button", { class: "act", title: "Starts the cut flow from these segments: it moves their borders to lower the distortion", onclick: on.handOver }, "Improve by the cut flow");
  const node = h("div", { class: "hierarchy", hidden: true }, list, line, improve);
  let items = new Map();
  let shape = "";
  let focusable = 0;

  list.addEventListener("keydown", (event) => {
    const all = [...list.querySelectorAll("[role=treeitem]")];
    const at = all.indexOf(document.activeElement);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: all.length - 1 }[event.key];
    const parent = event.key === "ArrowLeft" ? document.activeElement.parentElement.parentElement.closest("li")?.querySelector("[role=treeitem]") : null;
    const child = event.key === "ArrowRight" ? document.activeElement.parentElement.querySelector("ul [role=treeitem]") : null;
    const next = parent ?? child ?? all[to];
    if (!next) return;
    event.preventDefault();
    next.focus();
  });

  function build(nodes) {
    items = new Map();
    const branch = (parent) => {
      const children = nodes.filter((segment) => segment.parent === parent);
      return children.map((segment) => {
        const chip = h("i", { class: "chip" });
        const share = h("span", { class: "muted" });
        const button = h("button", { role: "treeitem", onclick: () => on.select(segment.node) }, chip, h("span", {}, segment.label), share);
        items.set(segment.node, { button, chip, share });
        const inner = branch(segment.node);
        return h("li", { role: "none" }, button, inner.length > 0 ? h("ul", { role: "group" }, ...inner) : null);
      });
    };
    list.replaceChildren(...branch(null));
  }

  function summary({ nodes, selected }) {
    const segment = nodes.find((other) => other.node === selected);
    if (!segment) return "";
    const parts = [segment.label === "Whole" ? "The whole surface" : `Segment ${segment.label}`, `${percent(segment.area_fraction)} of the area`];
    if (segment.length !== null) parts.push(`divided along ${measure(segment.length, "√A")}`);
    if (segment.loss !== null) parts.push(`loss of its parts ${short(segment.loss)}`);
    if (segment.components > 1) parts.push(plural(segment.components, "unconnected part"));
    return `${parts.join(", ")}.`;
  }

  return {
    node,
    /** Takes a `segments` event. */
    show(event) {
      const print = JSON.stringify(event.nodes.map((segment) => [segment.node, segment.parent]));
      if (print !== shape) {
        shape = print;
        build(event.nodes);
      }
      for (const segment of event.nodes) {
        const { button, chip, share } = items.get(segment.node);
        chip.className = segment.color === null ? "chip none" : `chip c${segment.color}`;
        write(share, percent(segment.area_fraction));
        const isSelected = segment.node === event.selected;
        button.setAttribute("aria-selected", String(isSelected));
        button.classList.toggle("busy", segment.node === event.active);
        if (isSelected) focusable = segment.node;
      }
      for (const [id, { button }] of items) button.tabIndex = id === focusable ? 0 : -1;
      write(line, summary(event));
      node.hidden = event.nodes.length === 0;
    },
    clear() {
      node.hidden = true;
      shape = "";
    },
  };
}
