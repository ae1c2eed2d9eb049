// The glossary: the field's words as this page uses them, in a dialog with a search field.

import { byId, h, icon, write } from "../dom.js";
import { WORDS } from "../glossary-words.js";

const plain = (text) => text.normalize("NFD").replace(/\p{Diacritic}/gu, "").replace(/[–-]/g, " ").toLowerCase();

/** Gives `open(word)`: shows the glossary, at a word where one is given. */
export function glossary() {
  const search = h("input", { type: "search", "aria-label": "Search the glossary", placeholder: "Search", autocomplete: "off", spellcheck: "false", oninput: filter });
  const found = h("p", { class: "muted", "aria-live": "polite" });
  const entries = WORDS.map(([name, text, others]) => ({
    name,
    index: plain(`${name} ${text} ${others}`),
    node: h("div", { tabindex: "-1" }, h("dt", {}, name), h("dd", {}, text)),
  }));
  const list = h("dl", { tabindex: "0", "aria-label": "Words" }, ...entries.map(({ node }) => node));
  const dialog = h(
    "dialog",
    { class: "glossary", id: "glossary-dialog", "aria-labelledby": "glossary-title" },
    h("header", {}, h("h2", { id: "glossary-title" }, "Glossary"), h("span", { class: "grow" }),
      h("button", { type: "button", class: "icon", "aria-label": "Close", title: "Close (Esc)", onclick: () => dialog.close() }, icon("close"))),
    h("label", { class: "search" }, icon("search"), search),
    found,
    list,
  );
  document.body.append(dialog);
  // What is typed here is no command to the page behind.
  dialog.addEventListener("keydown", (event) => {
    event.stopPropagation();
    // A search field would only empty itself.
    if (event.key !== "Escape") return;
    event.preventDefault();
    dialog.close();
  });
  dialog.addEventListener("click", ({ target }) => target === dialog && dialog.close());

  function filter() {
    const words = plain(search.value).split(/\s+/).filter(Boolean);
    let count = 0;
    for (const { index, node } of entries) {
      node.hidden = !words.every((word) => index.includes(word));
      count += node.hidden ? 0 : 1;
    }
    // Names that begin with what was typed come first.
    const start = words.join(" ");
    const rank = ({ name }) => (start !== "" && plain(name).startsWith(start) ? 0 : 1);
    list.replaceChildren(...[...entries].sort((a, b) => rank(a) - rank(b)).map(({ node }) => node));
    write(found, count === 0 ? "No word matches. Try a shorter one." : words.length === 0 ? `${count} words` : `${count} of ${entries.length} words`);
    list.scrollTop = 0;
  }

  function open(word) {
    search.value = "";
    filter();
    for (const { node } of entries) delete node.dataset.chosen;
    if (!dialog.open) dialog.showModal();
    const entry = word && entries.find(({ name }) => plain(name) === plain(word));
    if (entry) {
      entry.node.dataset.chosen = "";
      entry.node.focus({ preventScroll: true });
      entry.node.scrollIntoView({ block: "center" });
    } else search.focus();
  }
  byId("glossary").addEventListener("click", () => open());
  return { open };
}

/** Makes every `dfn` below a node a button that opens the glossary at its word: its title, or what it says. */
export function linkWords(node, open) {
  for (const dfn of node.querySelectorAll("dfn")) {
    const word = dfn.title || dfn.textContent;
    const button = h("button", { type: "button", class: "word", "aria-haspopup": "dialog", title: `${word}: see the glossary`, "data-word": word, onclick: () => open(word) }, dfn.textContent);
    // A line may break after a button: the mark that follows the word stays with it.
    const after = dfn.nextSibling;
    const [mark] = /^[.,:;)]+/.exec(after?.nodeType === Node.TEXT_NODE ? after.data : "") ?? [""];
    if (mark) after.data = after.data.slice(mark.length);
    dfn.replaceWith(mark ? h("span", { class: "together" }, button, mark) : button);
  }
}
