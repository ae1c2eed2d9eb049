// The brush: what it paints and how, in a line of tools under the head of the surface view.

import { byId, h, icon, roving, write } from "../dom.js";
import { dabQueue } from "../strokes.js";

/** Radii of the brush, in the unit of the scene, whose surface fits the unit ball. */
const SIZE = { least: 0.015, most: 0.6, first: 0.1 };
/** The ring that shows where a click will be. */
const POINT = 0.03;
/** One press of a key changes the size by this factor. */
const STEP = 1.25;
/** Labels that can be told apart by their colours. */
const LABELS = 9;
const NOTCHES = 100;

const fromNotch = (notch) => SIZE.least * (SIZE.most / SIZE.least) ** (notch / NOTCHES);
const toNotch = (size) => (NOTCHES * Math.log(size / SIZE.least)) / Math.log(SIZE.most / SIZE.least);

/** A slider among tools: its name, and a track that shows how far it is. */
function slider(label, text, value, change) {
  const input = h("input", { type: "range", min: 0, max: NOTCHES, step: "any", "aria-label": label, title: label, oninput: () => set(Number(input.value)) });
  function set(notch) {
    input.value = notch;
    input.style.setProperty("--v", `${input.value}%`);
    input.setAttribute("aria-valuetext", `${Math.round(input.value)} %`);
    change(Number(input.value));
  }
  set(value);
  return { node: h("label", { class: "amount" }, h("span", {}, text), input), set };
}

/**
 * @param views holds the brush: `setBrush(brush)`, `refreshBrush()`
 * @param on `paint(dab)`, `clear(channel)`, `circle(pick)` resolve when answered; `field(id)` shows a field;
 * `changed(isOn)` after it was taken or put away
 * @param facts gives `{ fields, current }`: the fields that there are, and the one that is shown
 */
export function brushPanel(views, on, facts) {
  const button = byId("brush");
  const host = byId("brush-tools");
  let channels = [];
  let channel = null;
  let label = 0;
  let size = SIZE.first;
  let strength = 1;
  let isOn = false;
  let isBlocked = false;
  /** Whether the next click starts a circle. */
  let placesCircle = false;
  let erases = false;
  /** Whether the drag that goes on is a stroke. */
  let isDrawn = false;
  /** The overlay that is to come back, and the one that the brush has chosen. */
  let before = null;
  let chosen = null;

  const queue = dabQueue(on.paint, on.rested);

  // The tools.

  const paint = h("select", { "aria-label": "Paint", onchange: () => choose(paint.value) });
  const swatches = h(
    "span",
    { class: "swatches", role: "radiogroup", "aria-label": "Region" },
    ...Array.from({ length: LABELS }, (_, i) =>
      h("button", { type: "button", role: "radio", "aria-label": `Region ${i + 1}`, title: `Region ${i + 1}`, "data-label": i, onclick: () => take(i) }, h("i", { class: `chip c${i}` })),
    ),
  );
  roving(swatches, "[role=radio]", (item) => take(Number(item.dataset.label)));
  const sizeSlider = slider("Brush size", "Size", toNotch(size), (notch) => {
    size = fromNotch(notch);
    views.refreshBrush();
  });
  const strengthSlider = slider("Brush strength", "Strength", NOTCHES, (notch) => (strength = Math.max(0.01, notch / NOTCHES)));
  const tool = (shape, name, title, press) => h("button", { class: "icon", "aria-label": name, title, onclick: press }, icon(shape));
  const erase = tool("eraser", "Erase", "Erase (E, or hold Alt)", () => setErase(!erases));
  const circle = tool("circle", "Circle start", "Circle start: the next click on the surface begins the cut as a circle there", () => setCircle(!placesCircle));
  const clear = tool("trash", "Clear", "", () => {
    queue.drop();
    on.clear(channel.id);
  });
  const hint = h("span", { class: "say", "aria-live": "polite" });
  host.append(
    h("span", { class: "pick" }, paint, icon("down")),
    swatches,
    sizeSlider.node,
    strengthSlider.node,
    hint,
    h("span", { class: "grow" }),
    erase,
    clear,
    circle,
  );
  button.addEventListener("click", () => (isOn ? put() : hold()));

  function take(next) {
    label = next;
    for (const swatch of swatches.children) {
      const isTaken = Number(swatch.dataset.label) === label;
      swatch.setAttribute("aria-checked", String(isTaken));
      swatch.tabIndex = isTaken ? 0 : -1;
    }
  }
  take(0);

  function setErase(isErasing) {
    erases = isErasing && channel?.kind !== "label";
    erase.setAttribute("aria-pressed", String(erases));
  }

  function setCircle(places) {
    placesCircle = places;
    circle.setAttribute("aria-pressed", String(places));
    explain();
    views.refreshBrush();
  }

  function explain() {
    const isPlace = channel?.kind === "place";
    write(hint, placesCircle ? "Click where the circle is to be" : isPlace ? "Click on the surface" : "");
    for (const [node, isShown] of [
      [swatches, !placesCircle && channel?.kind === "label"],
      [sizeSlider.node, !placesCircle && !isPlace],
      [strengthSlider.node, !placesCircle && channel?.kind === "amount"],
      [hint, placesCircle || isPlace],
      [erase, channel?.kind !== "label"],
      // A circle begins a cut, which methods without regions have no use for.
      [circle, channels.some(({ kind }) => kind === "label")],
    ]) {
      node.hidden = !isShown;
    }
    erase.disabled = placesCircle;
    clear.disabled = !channel || channel.is_empty;
    clear.title = channel ? `Clear: ${channel.label}` : "";
    paint.title = channel?.help ?? "";
  }

  function choose(id) {
    channel = channels.find((option) => option.id === id) ?? channels[0] ?? null;
    if (!channel) return;
    paint.value = channel.id;
    setErase(erases);
    setCircle(false);
    if (isOn) showChannel();
  }

  /** The painted field is seen while it is painted, where the engine has one for it. */
  function showChannel() {
    const { fields, current } = facts();
    const offered = fields.map((field) => field.id);
    const wanted = [channel.id, `${channel.id}s`, "pieces"].find((id) => offered.includes(id)) ?? "pieces";
    chosen = wanted;
    if (wanted !== current) on.field(wanted);
  }

  const brush = {
    radius: () => (placesCircle || channel?.kind === "place" ? POINT : size),
    /** Takes the dabs of a movement. */
    stroke(picks, begins, isAlt) {
      // What a click has set is not drawn on by the drag that follows.
      if (!begins && !isDrawn) return;
      isDrawn = !placesCircle && channel.kind !== "place";
      if (placesCircle) {
        setCircle(false);
        on.circle(picks[0]);
        return;
      }
      const isErasing = channel.kind !== "label" && erases !== isAlt;
      const value = channel.kind === "label" ? label : isErasing ? 0 : channel.kind === "place" ? 1 : strength;
      queue.add(
        picks.map(({ face, x, y, z }, i) => ({
          channel: channel.id,
          face,
          place: [x, y, z],
          radius: brush.radius(),
          value,
          begins: begins && i === 0,
        })),
      );
    },
  };

  function hold() {
    if (isOn || isBlocked || channels.length === 0) return;
    before = facts().current;
    isOn = true;
    show();
    choose(channel?.id);
    views.setBrush(brush);
  }

  /** Puts it away; the overlay from before comes back unless another was chosen since. */
  function put() {
    if (!isOn) return;
    isOn = false;
    setErase(false);
    setCircle(false);
    views.setBrush(null);
    const hadFocus = host.contains(document.activeElement);
    show();
    if (hadFocus) button.focus();
    if (before !== null && facts().current === chosen) on.field(before);
  }

  function show() {
    host.hidden = !isOn;
    button.setAttribute("aria-pressed", String(isOn));
    on.changed(isOn);
  }

  return {
    /** Takes a `paint_channels` event. */
    offer({ options }) {
      const isOther = options.length !== channels.length || options.some(({ id, label }, i) => id !== channels[i].id || label !== channels[i].label);
      channels = options;
      if (isOther) paint.replaceChildren(...options.map(({ id, label }) => h("option", { value: id }, label)));
      channel = options.find(({ id }) => id === channel?.id) ?? options[0] ?? null;
      if (channel) paint.value = channel.id;
      button.hidden = options.length === 0;
      if (!channel) put();
      explain();
    },
    offers: (id) => channels.some((option) => option.id === id),
    /** Takes the reason why nothing can be painted, null where it can. */
    block(reason) {
      isBlocked = reason !== null;
      button.disabled = isBlocked;
      button.title = reason ?? "Paint on the surface (B)";
      if (isBlocked) put();
    },
    isOn: () => isOn,
    toggle: () => !button.hidden && (isOn ? put() : hold()),
    put,
    /** What a key does while the brush is held; false for keys that it does not know. */
    key(name) {
      if (!isOn) return false;
      if (name === "[" || name === "]") {
        const next = Math.min(SIZE.most, Math.max(SIZE.least, name === "]" ? size * STEP : size / STEP));
        sizeSlider.set(toNotch(next));
      } else if (name === "e") setErase(!erases);
      else if (name === "Escape") {
        if (placesCircle) setCircle(false);
        else put();
      } else return false;
      return true;
    },
    /** The engine that waits for dabs is gone, or its surface. */
    drop: () => queue.drop(),
  };
}
