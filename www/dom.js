// A few lines in place of a framework: elements, icons, and calls at a bounded rate.

const SVG = "http://www.w3.org/2000/svg";

/** The element with this id. */
export const byId = (id) => document.getElementById(id);

/**
 * Makes an element. Keys that begin with `on` are listeners, `false`, `null` and `undefined` leave an attribute
 * out, `true` sets it empty; everything else is an attribute. Children are nodes or text.
 */
export function h(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

/** The same in the SVG namespace. */
export function s(tag, attributes = {}, ...children) {
  return fill(document.createElementNS(SVG, tag), attributes, children);
}

function fill(element, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/** An icon of the sprite in index.html. */
export const icon = (name) => s("svg", { "aria-hidden": "true" }, s("use", { href: `#i-${name}` }));

/** Writes text only where it differs, so that an unchanged cell costs no layout and no announcement. */
export function write(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** What waits for its turn to be drawn. */
const due = new Set();

/** Calls `draw` at most once in `interval` milliseconds; the last request is never lost. */
export function paced(interval, draw) {
  let last = -Infinity;
  let timer = 0;
  const call = () => {
    clearTimeout(timer);
    timer = 0;
    due.delete(call);
    last = performance.now();
    draw();
  };
  return () => {
    if (timer) return;
    timer = setTimeout(call, Math.max(0, last + interval - performance.now()));
    due.add(call);
  };
}

/** Draws at once whatever waits: what has come to rest is shown whole. */
export function settle() {
  for (const call of [...due]) call();
}

/** Arrow keys, Home and End move the focus inside a composite widget; `choose` is told the new item. */
export function roving(host, selector, choose) {
  host.addEventListener("keydown", (event) => {
    const items = [...host.querySelectorAll(selector)].filter((item) => !item.hidden);
    const at = items.indexOf(document.activeElement);
    const to = {
      ArrowRight: at + 1,
      ArrowDown: at + 1,
      ArrowLeft: at - 1,
      ArrowUp: at - 1,
      Home: 0,
      End: items.length - 1,
    }[event.key];
    if (to === undefined || at < 0) return;
    event.preventDefault();
    event.stopPropagation();
    const item = items[(to + items.length) % items.length];
    item.focus();
    choose?.(item);
  });
}

/** Small panels under their buttons: click or Escape outside closes, the focus goes back to the button. */
export function popover(button, panel, { opened } = {}) {
  const show = (open) => {
    if (panel.hidden === !open) return;
    panel.hidden = !open;
    button.setAttribute("aria-expanded", String(open));
    if (open) opened?.();
    else if (panel.contains(document.activeElement) || document.activeElement === document.body) button.focus();
  };
  button.setAttribute("aria-expanded", "false");
  button.addEventListener("click", () => show(panel.hidden));
  document.addEventListener("pointerdown", (event) => {
    if (!panel.contains(event.target) && !button.contains(event.target)) show(false);
  });
  for (const node of [button, panel]) {
    node.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || panel.hidden) return;
      event.stopPropagation();
      show(false);
    });
  }
  panel.addEventListener("focusout", (event) => {
    if (event.relatedTarget && !panel.contains(event.relatedTarget) && event.relatedTarget !== button) show(false);
  });
  return { show };
}
