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

/** What there is without a cut. */
const CUTLESS = ["Mesh (OBJ)", "Surface picture (PNG)", "Project (JSON)"];

/** `save(kind)` is called with the item's text, `pattern()` for the workshop of patterns. */
export function exportMenu(save, pattern) {
  const button = byId("export");
  const menu = byId("export-menu");
  const items = [...menu.querySelectorAll("[role=menuitem]")];
  const scales = [...menu.querySelectorAll("[role=menuitemradio]")];
  const { show } = popover(button, menu, { opened: () => items.find((item) => !item.disabled)?.focus() });
  roving(menu, "[role^=menuitem]:not(:disabled)");
  menu.addEventListener("click", ({ target }) => {
    const chosen = target.closest("[role=menuitemradio]");
    if (chosen) for (const scale of scales) scale.setAttribute("aria-checked", String(scale === chosen));
    const item = target.closest("[role=menuitem]");
    if (!item) return;
    show(false);
    button.focus();
    if (item.dataset.opens) pattern();
    else save(item.textContent);
  });
  menu.addEventListener("keydown", (event) => {
    if (event.key === "Tab") show(false);
  });
  button.addEventListener("keydown", (event) => {
    if (event.key !== "ArrowDown") return;
    event.preventDefault();
    show(true);
  });
  return {
    /** How many times larger pictures are saved. */
    scale: () => Number(scales.find((scale) => scale.getAttribute("aria-checked") === "true").value),
    /** Shows what the method has to save. */
    setMethod(id) {
      for (const item of items) item.hidden = (item.dataset.method ?? id) !== id;
    },
    /** Takes the reason why there is no cut to export, null where there is one. */
    block(reason) {
      for (const item of items) {
        item.disabled = reason !== null && !CUTLESS.includes(item.textContent);
        item.title = item.disabled ? reason : "";
      }
    },
  };
}
