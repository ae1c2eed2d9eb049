// The Export menu: an item's text is what the engine knows the file by, except for the two pictures.

import { byId, h, popover, roving } from "../dom.js";

/** Hands a file to the browser's downloads. */
export function download(name, blob) {
  const url = URL.createObjectURL(blob);
  const link = h("a", { href: url, download: name, hidden: true });
  document.body.append(link);
  link.click();
  link.remove();
  // Some browsers read the address only after the click has been dealt with.
  setTimeout(() => URL.revokeObjectURL(url), 30_000);
}

/** `save(kind)` is called with the item's text. */
export function exportMenu(save) {
  const button = byId("export");
  const menu = byId("export-menu");
  const items = [...menu.querySelectorAll("[role=menuitem]")];
  const { show } = popover(button, menu, { opened: () => items[0].focus() });
  roving(menu, "[role=menuitem]");
  menu.addEventListener("click", ({ target }) => {
    const item = target.closest("[role=menuitem]");
    if (!item) return;
    show(false);
    button.focus();
    save(item.textContent);
  });
  menu.addEventListener("keydown", (event) => {
    if (event.key === "Tab") show(false);
  });
  button.addEventListener("keydown", (event) => {
    if (event.key !== "ArrowDown") return;
    event.preventDefault();
    show(true);
  });
}
