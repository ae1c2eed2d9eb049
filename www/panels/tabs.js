// The two rows of tabs: the methods, and the panels that small screens show one at a time.

import { byId, roving } from "../dom.js";

/** Methods that are not built yet say so, also where the address `asked` for one. */
export function methodTabs(asked, say) {
  const list = document.querySelector(".methods [role=tablist]");
  function refuse(tab) {
    if (tab.getAttribute("aria-disabled") === "true") say(`“${tab.textContent}” is not built yet: this version has the cut flow.`);
  }
  list.addEventListener("click", ({ target }) => target.role === "tab" && refuse(target));
  roving(list, "[role=tab]");
  const tab = asked === "cutflow" ? null : byId(`tab-${asked}`);
  if (tab) refuse(tab);
}

/** Gives `toParameters()`, which shows the first panel. */
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
  toParameters();
  return { toParameters };
}
