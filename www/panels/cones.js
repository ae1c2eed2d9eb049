// The Cones table: one row a cone, linked with the views by hovering, by clicking and by the keys.

import { h, icon, paced, write } from "../dom.js";
import { count, fixed, inPi, parsePi, pi, plural } from "../format.js";

const INTERVAL = 80;
/** Rows beyond these are made on request: a slider may pass a thousand cones. */
const FIRST = 120;
/** How a cone came to its angle, where that is worth a mark. */
const KINDS = {
  merged: ["merge", (cone) => `Merged from ${plural(cone.members, "vertex", "vertices")}`],
  free: ["unlock", () => "Placed by hand; the optimum chooses its angle"],
  fixed: ["lock", () => "Its angle is fixed by hand"],
};

/** What is said of a cone besides its angle, null where there is nothing. */
export const kindOf = (cone) => KINDS[cone.kind]?.[1](cone) ?? null;

/** Six digits for the hand, without zeros that say nothing. */
const exact = (angle) => fixed(angle / Math.PI, 6).replace(/\.?0+$/, "");

/**
 * @param on `hover(cone)` and `select(cone)` (-1 for none), `setAngle(cone, angle)` (null sets it free),
 * `remove(cone)`, `toSurface()` when the keyboard wants to go there, `problem(sentence)`
 */
export function conesPanel(host, on) {
  let cones = [];
  let note = null;
  let order = [];
  let selected = -1;
  let hovered = -1;
  let most = FIRST;
  let isNews = false;
  const lines = [];
  const isNarrow = matchMedia("(max-width: 820px)");
  const body = h("tbody");
  const more = h("button", { class: "act", hidden: true, onclick: showAll });
  const nothing = h("p", { class: "muted", hidden: true });
  const table = h(
    "table",
    {},
    h("caption", { class: "sr" }, "Cones"),
    h(
      "thead",
      {},
      h(
        "tr",
        {},
        ...["Cones", "Angle", "Members", "Partner"].map((name) => h("th", { scope: "col" }, name)),
        h("th", { scope: "col" }, h("span", { class: "sr" }, "Remove")),
      ),
    ),
    body,
  );
  host.append(table, nothing, more);

  function line(i) {
    while (lines.length <= i) lines.push(newLine(lines.length));
    return lines[i];
  }

  function newLine(at) {
    const mine = () => order[at];
    const dot = h("i", { class: "dot" });
    const number = h("span");
    const pick = h("button", {
      class: "pickcone",
      type: "button",
      title: "Enter types its angle, M moves it to the middle of the surface view, Del removes it",
      tabindex: "-1",
      onclick: () => on.select(mine().cone),
      onfocus: () => on.select(mine().cone),
      onkeydown: (event) => walk(event, at),
    }, dot, number);
    const kind = h("span", { class: "kind", role: "img", hidden: true });
    const angle = h("input", {
      inputmode: "text",
      autocomplete: "off",
      spellcheck: "false",
      tabindex: "-1",
      title: "In units of π: 0.5, -1/2, π/3. Empty sets the angle free again.",
      onfocus: () => {
        on.select(mine().cone);
        angle.value = exact(mine().angle);
        angle.dataset.before = angle.value;
        angle.select();
      },
      onblur: () => commit(at),
      onkeydown: (event) => {
        if (event.key === "Escape") angle.value = angle.dataset.before;
        if (event.key !== "Enter" && event.key !== "Escape") return;
        event.stopPropagation();
        event.preventDefault();
        pick.focus();
      },
    });
    const remove = h("button", { class: "icon", type: "button", tabindex: "-1", title: "Remove (Del)", onclick: () => on.remove(mine().cone) }, icon("close"));
    const [members, partner] = [h("td"), h("td")];
    const row = h(
      "tr",
      { onpointerenter: () => on.hover(mine().cone), onpointerleave: () => on.hover(-1) },
      h("th", { scope: "row" }, pick, kind),
      h("td", {}, h("label", { class: "num" }, angle, h("span", {}, "π"))),
      members,
      partner,
      h("td", {}, remove),
    );
    return { row, pick, dot, number, kind, angle, members, partner, remove };
  }

  function commit(at) {
    const { angle } = lines[at];
    const cone = order[at];
    if (!cone) return;
    const text = angle.value.trim();
    const before = angle.dataset.before;
    const value = parsePi(text);
    angle.value = inPi(cone.angle);
    if (text === before) return;
    if (text === "" || /^free$/i.test(text)) on.setAngle(cone.cone, null);
    else if (Number.isFinite(value)) on.setAngle(cone.cone, value);
    else on.problem(`“${text}” is no angle. Write a number of π, such as 0.5, -1/2 or π/3.`);
  }

  /** Keys on the button of a row. */
  function walk(event, at) {
    const last = Math.min(order.length, most) - 1;
    const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: last }[event.key];
    if (to !== undefined) lines[Math.min(last, Math.max(0, to))].pick.focus();
    else if (event.key === "Enter" || event.key === "F2") lines[at].angle.focus();
    else if (event.key === "Delete" || event.key === "Backspace") on.remove(order[at].cone);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  function showAll() {
    most = Infinity;
    redraw();
    line(FIRST).pick.focus();
  }

  /** The largest first. While somebody is in the table rows keep their places, where they are still the same. */
  function sorted() {
    const isHeld = host.contains(document.activeElement) || host.matches(":hover");
    const places = new Map(order.map(({ cone }, i) => [cone, i]));
    if (isHeld && cones.length === order.length && cones.every(({ cone }) => places.has(cone))) {
      return cones.toSorted((a, b) => places.get(a.cone) - places.get(b.cone));
    }
    return cones.toSorted((a, b) => Math.abs(b.angle) - Math.abs(a.angle) || a.cone - b.cone);
  }

  const redraw = paced(INTERVAL, () => {
    const hadFocus = body.contains(document.activeElement) ? lines.findIndex(({ row }) => row.contains(document.activeElement)) : -1;
    order = sorted();
    const shown = Math.min(order.length, most);
    for (let i = 0; i < shown; i += 1) {
      const cone = order[i];
      const { row, pick, dot, number, kind, angle, members, partner, remove } = line(i);
      const name = `Cone ${cone.cone + 1}`;
      row.dataset.cone = cone.cone;
      dot.className = `dot ${cone.angle < 0 ? "minus" : "plus"}`;
      write(number, count(cone.cone + 1));
      pick.setAttribute("aria-label", `${name}, ${pi(cone.angle)}`);
      const [shape] = KINDS[cone.kind] ?? [];
      kind.hidden = !shape;
      if (shape && kind.dataset.kind !== cone.kind) kind.replaceChildren(icon(shape));
      kind.dataset.kind = cone.kind;
      const text = kindOf(cone) ?? "";
      kind.title = text;
      kind.setAttribute("aria-label", text);
      angle.setAttribute("aria-label", `Angle of cone ${cone.cone + 1}`);
      if (document.activeElement !== angle) angle.value = inPi(cone.angle);
      write(members, count(cone.members));
      write(partner, cone.partner === null || cone.partner === undefined ? "–" : count(cone.partner + 1));
      remove.setAttribute("aria-label", `Remove cone ${cone.cone + 1}`);
    }
    if (body.childElementCount !== shown) body.replaceChildren(...lines.slice(0, shown).map(({ row }) => row));
    // The row in focus may be gone: its neighbour takes over.
    if (hadFocus >= shown && shown > 0) lines[shown - 1].pick.focus({ preventScroll: true });
    more.hidden = order.length <= shown;
    write(more, `Show all ${count(order.length)}`);
    nothing.hidden = order.length > 0;
    write(nothing, note ?? "No cones yet. Run places them; the tool with the plus adds one by hand.");
    mark();
    if (isNews) reveal(selected);
    isNews = false;
  });

  function mark() {
    for (const { row, pick, angle, remove } of lines) {
      const cone = Number(row.dataset.cone);
      row.classList.toggle("chosen", cone === selected);
      row.classList.toggle("on", cone === hovered);
      pick.setAttribute("aria-pressed", String(cone === selected));
      const isEntry = cone === selected || (selected < 0 && row === lines[0]?.row);
      pick.tabIndex = isEntry ? 0 : -1;
      for (const control of [angle, remove]) control.tabIndex = cone === selected ? 0 : -1;
    }
  }

  function reveal(cone) {
    const row = lines.find(({ row }) => Number(row.dataset.cone) === cone && row.isConnected)?.row;
    if (!row || isNarrow.matches) return;
    const head = host.querySelector("thead").offsetHeight;
    if (row.offsetTop < host.scrollTop + head) host.scrollTop = row.offsetTop - head;
    else if (row.offsetTop + row.offsetHeight > host.scrollTop + host.clientHeight) {
      host.scrollTop = row.offsetTop + row.offsetHeight - host.clientHeight;
    }
  }

  return {
    /** Takes a `cones` event, and the cone that is the chosen one from now on. */
    show(event, chosen) {
      // Another vertex: its row is brought into sight once it is there.
      const vertexOf = (list, id) => list.find(({ cone }) => cone === id)?.vertex;
      isNews = chosen >= 0 && vertexOf(cones, selected) !== vertexOf(event.cones, chosen);
      selected = chosen;
      cones = event.cones;
      note = event.note;
      redraw();
    },
    cone: (id) => cones.find(({ cone }) => cone === id),
    hover(cone) {
      hovered = cone;
      mark();
      if (cone >= 0 && !host.matches(":hover")) reveal(cone);
    },
    select(cone) {
      selected = cone;
      mark();
      if (cone >= 0 && !host.matches(":hover")) reveal(cone);
    },
    selected: () => selected,
    /** The angle of a cone is asked for: the field in its row. */
    edit(cone) {
      const at = order.findIndex((one) => one.cone === cone);
      if (at >= 0 && at < most) line(at).angle.focus();
    },
  };
}
