// The texture of the pieces, drawn through the coordinates of the charts: what becomes of its cells on the surface shows
// what flattening does. Cells have a round real size, so that they can be read and compared with the material.

import { byId, h, write } from "../dom.js";
import { roundNear, roundText } from "../format.js";
import { recall, remember } from "../storage.js";

/** What the legend says before the size of a cell, by texture. */
const WORDS = { checkerboard: "checks of", grid: "grid of", circles: "circles every", spots: "", marble: "", image: "" };
/** The names of the choices in the storage: the texture, and the one that comes back. */
const [KEY, LAST_KEY, ATLAS_KEY] = ["texture", "texture.last", "atlas"];

/**
 * @param host says how large the cells are
 * @param on `refuse(event)` takes an `error` event, `atlas()` is called when overlapping charts are to be seen
 */
export function textureTool(views, host, on) {
  const button = byId("checkerboard");
  const select = byId("texture");
  const input = byId("texture-image");
  const atlas = byId("atlas");
  const isKnown = (name) => name !== null && Object.hasOwn(WORDS, name);
  const labels = Object.fromEntries([...select.options].map(({ value, text }) => [value, text]));
  // An image is not kept from visit to visit.
  const isKept = (name) => isKnown(name) && name !== "image";
  let last = [recall(LAST_KEY)].find(isKept) ?? "checkerboard";
  let shown = [recall(KEY)].find((name) => name === "none" || isKept(name)) ?? last;
  if (isKnown(shown)) last = shown;
  let cell = 0;
  let hasImage = false;

  function apply() {
    select.value = shown;
    button.setAttribute("aria-pressed", String(shown !== "none"));
    button.setAttribute("aria-label", labels[last]);
    button.title = `${labels[last]} (C)`;
    button.querySelector("use").setAttribute("href", `#i-${last}`);
    byId("other-image").hidden = shown !== "image";
    views.setTexture(shown, cell);
  }

  /** Makes an image file the texture; what is no image is refused. */
  async function take(file) {
    try {
      const whole = await createImageBitmap(file);
      const [width, height] = views.imageSize(whole.width, whole.height);
      const canvas = h("canvas", { width, height });
      const context = canvas.getContext("2d");
      context.imageSmoothingQuality = "high";
      context.drawImage(whole, 0, 0, width, height);
      whole.close();
      views.setImage({ width, height, bytes: new Uint8Array(context.getImageData(0, 0, width, height).data.buffer) });
      hasImage = true;
      choose("image");
    } catch (reason) {
      on.refuse({
        what: `${file.name} is no image that this browser can read.`,
        where: String(reason?.message ?? reason),
        what_to_do: "Choose a PNG, JPEG, WebP, GIF or AVIF file.",
      });
    }
  }

  function choose(name) {
    if (name === "image" && !hasImage) {
      // Until there is one, what is shown stays.
      apply();
      input.click();
      return;
    }
    shown = name;
    if (isKnown(name)) last = name;
    remember(KEY, shown);
    remember(LAST_KEY, last);
    apply();
  }

  button.addEventListener("click", () => choose(shown === "none" ? last : "none"));
  select.addEventListener("change", () => choose(select.value));
  input.addEventListener("change", () => {
    const [file] = input.files;
    // The same file may be chosen again after it was changed.
    input.value = "";
    if (file) take(file);
  });
  const isMode = (name) => [...atlas.options].some(({ value }) => value === name);
  atlas.value = [recall(ATLAS_KEY)].find(isMode) ?? "pieces";
  views.setLayers(atlas.value);
  atlas.addEventListener("change", () => {
    remember(ATLAS_KEY, atlas.value);
    views.setLayers(atlas.value);
    if (atlas.value !== "pieces") on.atlas();
  });
  apply();

  return {
    take,
    /** The texture and how charts that overlap are drawn, for a link: `image` cannot travel. */
    chosen: () => ({ texture: isKept(shown) || shown === "none" ? shown : null, atlas: atlas.value }),
    /** Shows what a link asks for, as long as nobody chooses; names that there are none of change nothing. */
    ask(asked) {
      if (asked.texture === "none" || isKept(asked.texture)) shown = asked.texture;
      if (isKept(shown)) last = shown;
      if (isMode(asked.atlas)) {
        atlas.value = asked.atlas;
        views.setLayers(atlas.value);
      }
      apply();
    },
    /** Takes a scene: how overlapping charts are drawn can be chosen where it has any. */
    scene(scene) {
      byId("atlas-choice").hidden = !scene?.layers;
    },
    /** Takes the pattern, which says what a unit of the charts is worth; to be called after something was drawn. */
    show(pattern) {
      const usual = views.usualCell();
      const length = pattern?.unit_length > 0 && usual > 0 ? roundNear(usual * pattern.unit_length) : 0;
      const wanted = length > 0 ? length / pattern.unit_length : 0;
      if (wanted !== cell) {
        cell = wanted;
        views.setTexture(shown, cell);
      }
      const text = length > 0 && WORDS[shown] ? `${WORDS[shown]} ${roundText(length)}\u00a0${pattern.unit}` : "";
      host.hidden = text === "";
      write(host, text);
    },
  };
}
