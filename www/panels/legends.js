// What lies low in each view: the colour map of the field shown, or what the pieces amount to.

import { h, s } from "../dom.js";
import { wordsOf } from "../fields.js";
import { fixed, patternLength, percent, plural } from "../format.js";

const line = (strong, text) => [h("div", { class: "line" }, h("b", {}, strong), " ", h("span", {}, text))];

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
  const words = wordsOf(field);
  const stat = (name, value) => [h("span", {}, `${name} `, h("b", {}, words.value(value))), " "];
  return [
    h(
      "div",
      { class: "scale" },
      s("svg", { viewBox: `0 0 ${Math.max(1, 7 * bins.length)} 20`, preserveAspectRatio: "none", "aria-hidden": "true" }, ...bars),
      h("i", { class: field.signed ? "ramp diverging" : "ramp" }),
      h("p", {}, h("span", {}, words.end(low)), field.signed ? h("span", {}, "0") : null, h("span", {}, words.end(high))),
    ),
    h(
      "div",
      {},
      h("p", { class: "title" }, h("b", {}, words.label), " ", h("span", {}, words.unit)),
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
  const wait = waiting > 0 ? [`${plural(waiting, "piece")} not flattened yet`] : [];
  if (pattern) {
    const filled = pattern.filled ? [`${fixed(100 * pattern.filled, 0)} % filled`] : [];
    const [width, height] = [pattern.width, pattern.height].map((length) => patternLength(length, pattern.unit));
    // Flips and overlaps have their own place over the charts.
    return line(`${width} × ${height} ${pattern.unit}`, [...filled, ...wait].join(", "));
  }
  const turned = flipped > 0 ? [plural(flipped, "flipped triangle")] : waiting > 0 ? [] : ["no flipped triangles"];
  return line(plural(patches.length - waiting, "chart"), [...wait, ...turned].join(", "));
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
