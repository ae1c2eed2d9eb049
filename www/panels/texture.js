// The texture of the pieces, drawn through the coordinates of the charts: what becomes of its cells on the surface shows
// what flattening does. Cells have a round real size, so that they can be read and compared with the material.

import { byId, write } from "../dom.js";
import { roundNear, roundText } from "../format.js";
import { recall, remember } from "../storage.js";

/** What the legend says before the size of a cell, by texture. */
const WORDS = { checkerboard: "checks of", grid: "grid of", circles: "circles every" };
/** The names of the choices in the storage: the texture, and the one that comes back. */
const [KEY, LAST_KEY] = ["texture", "texture.last"];

export function textureTool(views, host) {
  const button = byId("checkerboard");
  const select = byId("texture");
  const isKnown = (name) => name !== null && Object.hasOwn(WORDS, name);
  const labels = Object.fromEntries([...select.options].map(({ value, text }) => [value, text]));
  let last = [recall(LAST_KEY)].find(isKnown) ?? "checkerboard";
  let shown = [recall(KEY)].find((name) => name === "none" || isKnown(name)) ?? last;
  if (isKnown(shown)) last = shown;
  let cell = 0;

  function apply() {
    select.value = shown;
    button.setAttribute("aria-pressed", String(shown !== "none"));
    button.setAttribute("aria-label", labels[last]);
    button.title = `${labels[last]} (C)`;
    button.querySelector("use").setAttribute("href", `#i-${last}`);
    views.setTexture(shown, cell);
  }

  function choose(name) {
    shown = name;
    if (isKnown(name)) last = name;
    remember(KEY, shown);
    remember(LAST_KEY, last);
    apply();
  }

  button.addEventListener("click", () => choose(shown === "none" ? last : "none"));
  select.addEventListener("change", () => choose(select.value));
  apply();

  return {
    /** Takes the pattern, which says what a unit of the charts is worth; to be called after something was drawn. */
    show(pattern) {
      const usual = views.usualCell();
      const length = pattern?.unit_length > 0 && usual > 0 ? roundNear(usual * pattern.unit_length) : 0;
      const wanted = length > 0 ? length / pattern.unit_length : 0;
      if (wanted !== cell) {
        cell = wanted;
        views.setTexture(shown, cell);
      }
      const text = length > 0 && isKnown(shown) ? `${WORDS[shown]} ${roundText(length)}\u00a0${pattern.unit}` : "";
      host.hidden = text === "";
      write(host, text);
    },
  };
}
