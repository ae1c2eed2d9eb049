// The two rows of tabs: the methods, and the panels that small screens show one at a time.

import { byId, roving } from "../dom.js";

const NOT_BUILT = "Not built yet";

/** `choose(id)` is called with another method; those that are not built yet say so. */
export function methodTabs(choose, say) {
  const list = document.querySelector(".methods [role=tablist]");
  const isMissing = (tab) => tab.getAttribute("aria-disabled") === "true";
  const refuse = (tab) => say(`“${tab.textContent}” is not built yet.`);
  list.addEventListener("click", ({ target }) => {
    if (target.role !== "tab") return;
    if (isMissing(target)) refuse(target);
    else if (target.getAttribute("aria-selected") !== "true") choose(target.id.slice("tab-".length));
  });
  // Arrows move the focus only: another method begins another piece of work.
  roving(list, "[role=tab]");
  return {
    /** Takes a `methods` event. */
    show({ current, options }) {
      for (const tab of list.children) {
        const option = options.find(({ id }) => tab.id === `tab-${id}`);
        const isThere = option?.available === true;
        const isCurrent = tab.id === `tab-${current}`;
        if (isThere) tab.removeAttribute("aria-disabled");
        else tab.setAttribute("aria-disabled", "true");
        tab.title = isThere ? "" : NOT_BUILT;
        tab.setAttribute("aria-selected", String(isCurrent));
        tab.tabIndex = isCurrent ? 0 : -1;
      }
    },
    /** Says of a method that an address asks for that it is not built, or that there is none. */
    refuse(id) {
      const tab = byId(`tab-${id}`);
      if (tab) refuse(tab);
      else say(`There is no method named ${id}.`);
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
