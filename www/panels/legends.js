// What lies low in each view: the colour map of the field shown, or what the pieces amount to.

import { h, s } from "../dom.js";
import { among, fixed, percent, plural, short } from "../format.js";

/** `+0.10` and `−0.10`; the ends of a range want no more digits than tell them apart. */
function end(value, signed) {
  const size = Math.abs(value);
  const text = size >= 1e-3 && size < 1e4 ? fixed(value, size >= 100 ? 0 : size >= 1 ? 1 : size >= 0.1 ? 2 : 3) : short(value);
  return signed && value > 0 ? `+${text}` : text;
}

const line = (strong, text) => [h("div", {}, h("b", {}, strong), " ", text)];

function fieldLegend(field) {
  // Labels are names: they have no range and no mean.
  if (field.id === "regions") return line(field.label, "in the colours of the brush");
  const [low, high] = field.range;
  const bins = field.histogram;
  const bars = bins.map((share, i) => {
    // The root lets small shares be seen beside the largest.
    const height = 20 * Math.sqrt(Math.max(0, share));
    return s("rect", { x: 7 * i, y: 20 - height, width: 6, height });
  });
  const size = Math.max(...field.extremes.map(Math.abs));
  const stat = (name, value) => [`${name} `, h("b", {}, among(value, size)), " "];
  return [
    h(
      "div",
      { class: "scale" },
      s("svg", { viewBox: `0 0 ${Math.max(1, 7 * bins.length)} 20`, preserveAspectRatio: "none", "aria-hidden": "true" }, ...bars),
      h("i", { class: field.signed ? "ramp diverging" : "ramp" }),
      h("p", {}, h("span", {}, end(low, field.signed)), field.signed ? h("span", {}, "0") : null, h("span", {}, end(high, field.signed))),
    ),
    h(
      "div",
      {},
      h("b", {}, field.label),
      " ",
      h("span", {}, field.unit),
      h("p", { class: "stats" }, ...stat("min", field.extremes[0]), ...stat("mean", field.mean), ...stat("max", field.extremes[1])),
    ),
  ];
}

// A mesh that is not cut yet has no pieces to tell of.
const isUncut = (patches) => patches.every((patch) => patch.area_fraction === 0);

function surfaceSummary({ patches }) {
  if (isUncut(patches)) return [];
  const shares = patches.map((patch) => patch.area_fraction);
  const [least, most] = [Math.min(...shares), Math.max(...shares)].map(percent);
  if (patches.length === 1) return line("1 piece", "the whole surface");
  const range = least === most ? least : `${least.replace(/\s%/, "")} to ${most}`;
  return line(plural(patches.length, "piece"), `${range} of the area each`);
}

function flatSummary({ patches }, pattern) {
  if (isUncut(patches)) return [];
  const waiting = patches.filter((patch) => !patch.has_chart).length;
  const flipped = patches.reduce((sum, patch) => sum + patch.flipped, 0);
  const state = [
    waiting > 0 ? `${plural(waiting, "piece")} not flattened yet` : null,
    flipped > 0 ? plural(flipped, "flipped triangle") : waiting > 0 ? null : "no flipped triangles",
  ].filter(Boolean);
  if (pattern) {
    const filled = pattern.filled ? [`${fixed(100 * pattern.filled, 0)} % filled`] : [];
    const size = `${fixed(pattern.width, 0)} × ${fixed(pattern.height, 0)} ${pattern.unit}`;
    const crossed = pattern.overlaps > 0 ? [`outlines cross ${plural(pattern.overlaps, "time")}`] : [];
    return line(size, [...filled, ...(waiting + flipped > 0 ? state : []), ...crossed].join(", "));
  }
  return line(plural(patches.length - waiting, "chart"), state.join(", "));
}

export function legends(surface, flat) {
  let shown = "";
  return {
    /**
     * Takes a scene, the size of the pattern where it is known, what is marked in place of the pieces, if anything,
     * and the two parts of what a preview says of the surface, if there is one.
     */
    show(scene, pattern, marked, preview) {
      const patches = scene.patches.map((p) => [p.area_fraction, p.has_chart, p.flipped]);
      const print = JSON.stringify([scene.field, patches, pattern, marked, preview]);
      if (print === shown) return;
      shown = print;
      if (marked) {
        const text = h("span", { title: marked }, marked);
        surface.replaceChildren(h("div", { class: "marked" }, h("i", { class: "chip mark" }), text));
        flat.replaceChildren();
      } else if (preview) {
        const [strong, text] = preview;
        surface.replaceChildren(h("div", { class: "preview" }, h("b", {}, strong), h("span", {}, text)));
        flat.replaceChildren(...(scene.field ? fieldLegend(scene.field) : flatSummary(scene, pattern)));
      } else if (scene.field) {
        surface.replaceChildren(...fieldLegend(scene.field));
        flat.replaceChildren(...fieldLegend(scene.field));
      } else {
        surface.replaceChildren(...surfaceSummary(scene));
        flat.replaceChildren(...flatSummary(scene, pattern));
      }
    },
  };
}
