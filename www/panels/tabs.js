// The two rows of tabs: the methods, and the panels that small screens show one at a time.

import { byId, roving } from "../dom.js";

/** `choose(id)` is called with another method. */
export function methodTabs(choose, say) {
  const list = document.querySelector(".methods [role=tablist]");
  list.addEventListener("click", ({ target }) => {
    if (target.role !== "tab") return;
    if (target.getAttribute("aria-selected") !== "true") choose(target.id.slice("tab-".length));
  });
  // Arrows move the focus only: another method begins another piece of work.
  roving(list, "[role=tab]");
  return {
    /** Takes a `methods` event. */
    show({ current }) {
      for (const tab of list.children) {
        const isCurrent = tab.id === `tab-${current}`;
        tab.setAttribute("aria-selected", String(isCurrent));
        tab.tabIndex = isCurrent ? 0 : -1;
        // Narrow windows show a part of the row.
        if (isCurrent) tab.scrollIntoView({ block: "nearest", inline: "nearest" });
      }
    },
    /** Whether there is such a method; says so where there is none. */
    has(id) {
      const isThere = byId(`tab-${id}`) !== null;
      if (!isThere) say(`There is no method named ${id}.`);
      return isThere;
    },
  };
}

/** Gives `toParameters()` and `toMeasures()`, which show those panels, and `name(texts)`, which names panels anew. */
export function sheetTabs() {
  const sheet = document.querySelector(".sheet");
  function show(tab) {
    document.documentElement.dataset.sheet = tab.dataset.sheet;
    for (const other of sheet.children) {
      other.setAttribute("aria-selected", String(other === tab));
      other.tabIndex = other === tab ? 0 : -1;
    }
  }
  sheet.addEventListener("click", ({ target }) => target.role === "tab" && show(target));
  roving(sheet, "[role=tab]", show);
  const toParameters = () => show(sheet.firstElementChild);
  const toMeasures = () => show(sheet.querySelector("[data-sheet=measures]"));
  toParameters();
  function name(texts) {
    for (const tab of sheet.children) tab.textContent = texts[tab.dataset.sheet] ?? tab.textContent;
  }
  return { toParameters, toMeasures, name };
}
