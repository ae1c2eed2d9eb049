// Compare: results of several methods or settings on the open mesh side by side, as pictures and as a table. The engine runs, keeps and
// measures; the page takes the pictures, with the camera where it is, as each result is drawn.

import { byId, h, icon, write } from "../dom.js";
import { measure, plural } from "../format.js";

/** What one asks for a second time rarely: the table as a file. */
const FILE = "Comparison (CSV)";
/** A picture in pixels; shown at half of that at most. */
const PICTURE = [480, 360];
/** How long the next run waits for a picture: a hidden tab draws none. */
const WAIT_MS = 10_000;
const HIDDEN_MS = 500;
/** Rows in which everything above zero is a fault. */
const FAULTS = ["flipped", "overlaps"];

/**
 * @param on `send(command)`, `run(command)` for what acts on the cut, `wait(sentence, command)` for what may take a while, `save(kind)`,
 * `picture(isSurface, width, height)` gives a canvas or null, `opening()` before the panel is shown
 */
export function comparePanel(on) {
  const root = document.documentElement;
  const button = byId("results-open");
  const panel = byId("results");
  let table = { results: [], rows: [], current: null, progress: null };
  /** What an engine knew that is no more: its results and their rows, as they were. */
  let lost = { results: [], rows: [] };
  /** Engines that were lost: the numbers of results begin anew with each. */
  let engines = 0;
  /** Names of lost results that are being made again. */
  let awaited = new Set();
  let methods = [];
  /** Card and pictures of each result. */
  const cards = new Map();
  /** The result that is to be taken a picture of, once a scene that came after is drawn. */
  let due = null;
  let hasScene = false;
  let late = 0;
  let blocked = false;

  const title = h("h2", { id: "results-title", tabindex: "-1" }, "Compare");
  const keep = h("button", { type: "button", class: "btn outlined", title: "Keeps what the views show now, to compare it with others", onclick: keepNow }, icon("plus"), h("span", {}, "Keep this result"));
  const boxes = h("span", { class: "boxes", role: "group", "aria-label": "Methods to compare" });
  const run = h("button", { type: "button", class: "btn primary", title: "Runs each on this mesh with its present parameters; what is open stays as it is", onclick: compareAll }, icon("run"), h("span", {}, "Compare methods"));
  const stop = h("button", { type: "button", class: "btn outlined", hidden: true, title: "No more runs; the results so far stay", onclick: () => on.send({ type: "cancel" }) }, icon("close"), h("span", {}, "Stop comparing"));
  const progress = h("span", { class: "muted progress", "aria-live": "polite" });
  const save = h("button", { type: "button", class: "btn", title: "Comma-separated values: a line for each result", onclick: () => on.save(FILE) }, icon("export"), h("span", {}, "Save table (CSV)"));
  const close = h("button", { type: "button", class: "icon", "aria-label": "Close Compare", title: "Close (Esc)", onclick: () => show(false) }, icon("close"));
  const list = h("ul", { class: "cards", "aria-label": "Results" });
  const head = h("thead");
  const body = h("tbody");
  const sheet = h("div", { class: "numbers-table", tabindex: "0", role: "group", "aria-label": "Comparison, scrolls" }, h("table", {}, h("caption", { class: "sr" }, "Comparison"), head, body));
  const renew = h(
    "button",
    { type: "button", class: "btn outlined", title: "Runs each of them again, to its end, with the parameters that it had", onclick: makeAgain },
    icon("run"),
    h("span", {}, "Run them again"),
  );
  const past = h("p", { class: "past", hidden: true }, h("span"), renew);
  const nothing = h(
    "p",
    { class: "nothing" },
    h("b", {}, "Nothing to compare yet."),
    " Compare methods runs each one on this mesh with its present parameters. Or run a method, keep its result, change a parameter and keep that one too.",
  );
  panel.append(
    h("header", {}, title, h("span", { class: "grow" }), save, close),
    h("div", { class: "ask" }, keep, h("span", { class: "pickers" }, boxes, run), stop, progress, past),
    nothing,
    h("div", { class: "results" }, list, sheet),
  );

  button.addEventListener("click", () => show(panel.hidden));
  // Learn takes the same room.
  byId("learn").addEventListener("click", () => show(false), { capture: true });
  panel.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    show(false);
  });

  function show(isOpen) {
    if (panel.hidden !== isOpen) return;
    if (isOpen) on.opening();
    panel.hidden = !isOpen;
    button.setAttribute("aria-expanded", String(isOpen));
    if (isOpen) root.dataset.compare = "";
    else delete root.dataset.compare;
    if (isOpen) title.focus();
    else if (panel.contains(document.activeElement) || document.activeElement === document.body) button.focus();
  }

  function keepNow() {
    return on.wait("Keeping this result", { type: "keep_result" });
  }

  function compareAll() {
    const runs = [...boxes.querySelectorAll("input:checked")].map(({ value }) => ({ method: value }));
    if (runs.length > 0) on.run({ type: "compare", runs, waits: true });
  }

  /** Lost results come back by runs of their own; each makes room as it comes. */
  function makeAgain() {
    const runs = lost.results.map(({ method, name, values }) => ({ method, name, values }));
    awaited = new Set(runs.map(({ name }) => name));
    on.run({ type: "compare", runs, waits: true });
  }

  /** Results of the engine before and of this one. */
  const all = () => [...lost.results, ...table.results];

  /** What has been made again is no longer lost. */
  function replaceLost() {
    const made = new Set(table.results.map(({ name }) => name).filter((name) => awaited.has(name)));
    if (made.size > 0) keepLost(lost.results.filter(({ name }) => !made.has(name)));
  }

  /** Keeps these of the lost results, each with its column. */
  function keepLost(results) {
    const columns = results.map((result) => lost.results.indexOf(result));
    lost = { results, rows: lost.rows.map((row) => ({ ...row, values: columns.map((i) => row.values[i]) })) };
  }

  /** The table of all results. What is best among them only one engine can say that knows all. */
  function rows() {
    if (lost.results.length === 0) return table.rows;
    const known = [...lost.rows, ...table.rows.filter(({ id }) => lost.rows.every((row) => row.id !== id))];
    const part = (of, id) => of.rows.find((row) => row.id === id)?.values ?? of.results.map(() => null);
    return known.map((row) => ({ ...row, values: [...part(lost, row.id), ...part(table, row.id)], best: [] }));
  }

  function offer() {
    const isBusy = table.progress !== null;
    const isAny = boxes.querySelector("input:checked") !== null;
    run.disabled = isBusy || !isAny;
    keep.disabled = isBusy;
    stop.hidden = !isBusy;
    save.disabled = table.results.length === 0;
    nothing.hidden = all().length > 0 || isBusy;
    list.parentElement.hidden = all().length === 0;
    past.hidden = lost.results.length === 0;
    renew.disabled = isBusy || blocked;
    const stay = `${plural(lost.results.length, "result")} from before ${lost.results.length === 1 ? "stays" : "stay"} to be read`;
    write(past.firstElementChild, `The solver was started again: ${stay}, and cannot be shown or saved.`);
    const now = table.progress;
    write(progress, now ? `${now.is_held ? "Paused" : "Running"}: ${now.label}, ${now.at} of ${now.of}` : "");
  }

  function cardOf(result) {
    if (cards.has(result.id)) return cards.get(result.id);
    const pictures = h("div", { class: "pictures" });
    const name = h("input", {
      class: "called",
      maxlength: "80",
      "aria-label": "Name",
      onchange() {
        if (name.value.trim() === "") name.value = card.result.name;
        else on.send({ type: "rename_result", id: card.result.id, name: name.value });
      },
      onkeydown(event) {
        if (event.key === "Enter") name.blur();
        if (event.key !== "Escape") return;
        event.stopPropagation();
        name.value = card.result.name;
        name.blur();
      },
    });
    const badge = h("span", { class: "badge", hidden: true }, "Shown now");
    const facts = h("p", { class: "fine" });
    const note = h("p", { class: "note" });
    const again = h("button", { type: "button", class: "act", onclick: () => on.wait(`Showing ${name.value}`, { type: "restore_result", id: card.result.id }) }, icon("eye"), "Show");
    const remove = h("button", { type: "button", class: "act", onclick: () => drop(card.result.id) }, icon("trash"), "Remove");
    const node = h("li", {}, pictures, h("div", { class: "line" }, name, badge), facts, note, h("div", { class: "acts" }, again, remove));
    const card = { node, pictures, name, badge, facts, note, again, remove, result, isTaken: false };
    cards.set(result.id, card);
    return card;
  }

  /** The focus of a card that goes stays among the cards. */
  async function drop(id) {
    const at = all().findIndex((result) => result.id === id);
    if (cards.get(id).result.isLost) {
      keepLost(lost.results.filter((result) => result.id !== id));
      showAll();
    } else await on.send({ type: "remove_result", id });
    const next = all()[Math.min(at, all().length - 1)];
    (next ? cards.get(next.id).remove : title).focus();
  }

  function showCards() {
    for (const [id, { node }] of cards) {
      if (all().some((result) => result.id === id)) continue;
      node.remove();
      cards.delete(id);
    }
    all().forEach((result, i) => {
      const card = cardOf(result);
      card.result = result;
      const isCurrent = result.id === table.current;
      card.node.classList.toggle("current", isCurrent);
      card.node.setAttribute("aria-label", result.name);
      if (document.activeElement !== card.name) card.name.value = result.name;
      card.badge.hidden = !isCurrent;
      const settings = result.settings.map(({ label, text }) => `${label} ${text}`);
      write(card.facts, [result.method_label, ...settings, result.status].join(" · "));
      write(card.note, result.note ?? "");
      card.note.classList.toggle("failed", !result.has_result);
      card.again.disabled = result.isLost || !result.has_result || isCurrent || table.progress !== null;
      card.name.readOnly = result.isLost === true;
      card.again.setAttribute("aria-label", `Show ${result.name}`);
      card.remove.setAttribute("aria-label", `Remove ${result.name}`);
      if (!card.isTaken && card.pictures.childElementCount === 0) {
        card.pictures.append(h("p", { class: "none" }, result.has_result ? "Show it for a picture" : "No result"));
      }
      if (list.children[i] !== card.node) list.insertBefore(card.node, list.children[i] ?? null);
    });
  }

  function showTable() {
    head.replaceChildren(
      h("tr", {}, h("th", { scope: "col" }, "Measure"), ...all().map(({ name, id }) => h("th", { scope: "col", class: id === table.current ? "current" : null }, name))),
    );
    body.replaceChildren(
      ...rows().map((row) =>
        h(
          "tr",
          {},
          h("th", { scope: "row" }, row.label),
          ...row.values.map((value, i) => {
            const isFault = FAULTS.includes(row.id) && value > 0;
            const cell = h("td", { class: isFault ? "fault" : row.best[i] ? "best" : null }, measure(value, row.unit));
            if (isFault) cell.append(h("small", {}, "not safe to cut"));
            else if (row.best[i]) cell.append(h("small", {}, row.word));
            return cell;
          }),
        ),
      ),
    );
  }

  function showAll() {
    showCards();
    showTable();
    offer();
  }

  /** Decides what is to be taken a picture of. */
  function awaitPicture() {
    const wanted = table.progress?.waits_for ?? table.current;
    const isMissing = wanted !== null && cards.get(wanted)?.isTaken === false && cards.get(wanted).result.has_result;
    const next = isMissing ? wanted : null;
    if (next === due) return;
    due = next;
    hasScene = false;
    clearTimeout(late);
    if (due !== null) late = setTimeout(goOn, document.hidden ? HIDDEN_MS : WAIT_MS);
  }

  function goOn() {
    clearTimeout(late);
    const isAwaited = table.progress?.waits_for === due && due !== null;
    due = null;
    if (isAwaited) on.send({ type: "next_result" });
  }

  return {
    /** Takes a `comparison` event. */
    show(event) {
      const isNew = event.results.length > table.results.length;
      table = event;
      replaceLost();
      if (table.progress === null) awaited.clear();
      showAll();
      awaitPicture();
      button.title = `Compare methods and settings on this mesh${all().length > 0 ? `: ${plural(all().length, "result")}` : ""}`;
      if (isNew) list.lastElementChild?.scrollIntoView({ block: "nearest", inline: "nearest" });
    },
    /**
     * The engine is gone, and with it what brings results back: pictures and numbers stay. `usual` holds, by method, the values that the mesh
     * was opened with.
     */
    lose(usual) {
      engines += 1;
      const kept = table.results.map((result) => {
        const id = `${engines} ${result.id}`;
        cards.set(id, cards.get(result.id));
        cards.delete(result.id);
        const values = { ...usual[result.method] };
        // How large the model is changes no measure here.
        for (const size of ["size", "unit"]) delete values[size];
        for (const setting of result.settings) values[setting.id] = setting.value;
        return { ...result, id, values, isLost: true };
      });
      lost = { results: [...lost.results, ...kept], rows: rows() };
      table = { results: [], rows: [], current: null, progress: null };
      awaited.clear();
      awaitPicture();
      showAll();
    },
    /** Another mesh: what was lost of the one before is of no use. */
    forget() {
      if (lost.results.length === 0) return;
      lost = { results: [], rows: [] };
      showAll();
    },
    /** Takes a `methods` event. */
    methods({ options }) {
      if (methods.length === options.length) return;
      methods = options;
      boxes.replaceChildren(
        ...options.map(({ id, label }) => h("label", {}, h("input", { type: "checkbox", value: id, checked: true, onchange: offer }), label)),
      );
      offer();
    },
    /** A scene has come: the next that is drawn is no older. */
    scene() {
      hasScene = true;
    },
    /** The views were drawn. */
    drawn() {
      if (due === null || !hasScene) return;
      const card = cards.get(due);
      const pictures = [true, false].map((isSurface) => on.picture(isSurface, ...PICTURE));
      if (card && pictures.every(Boolean)) {
        card.isTaken = true;
        pictures.forEach((picture, i) => {
          picture.setAttribute("role", "img");
          picture.setAttribute("aria-label", i === 0 ? "Surface" : "Flattened");
        });
        card.pictures.replaceChildren(...pictures);
      }
      goOn();
    },
    /** Takes the reason why nothing can be compared, null where it can. */
    block(reason) {
      blocked = reason !== null;
      button.disabled = blocked;
      button.title = reason ?? "Compare methods and settings on this mesh";
      if (reason !== null) show(false);
    },
    close: () => show(false),
    isOpen: () => !panel.hidden,
  };
}
