// Overlapping charts, drawn by a viewer of their own from a scene made by hand: a square that faces the eye, covered by two charts whose
// weights pass from one to the other across its middle third.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { PAGE, RENDERERS, open, screenshot } from "./chromium.mjs";
import { Page } from "./page.mjs";
import { decodePng, difference } from "./pixels.mjs";

/** Steps of 255 by which backends and sums of rounded shares may differ in the mean: see page.test.mjs. */
const ALIKE = 3;

/** Runs in the page: makes a viewer on two canvases of its own. */
async function make(renderer) {
  const { default: init, Viewer } = await import(new URL("www/pkg/viewer.js", location.href));
  await init();
  const canvases = ["Layers surface", "Layers flat"].map((label, i) => {
    const canvas = document.createElement("canvas");
    canvas.setAttribute("aria-label", label);
    canvas.style.cssText = `position: fixed; z-index: 99; top: 0; left: ${320 * i}px; width: 300px; height: 300px`;
    document.body.append(canvas);
    return canvas;
  });
  const viewer = await Viewer.create(...canvases, renderer);
  for (const view of [0, 1]) viewer.resize(view, 300, 300, 1);
  window.layersViewer = viewer;
}

/** Runs in the page: shows charts of two colours; `isOne` leaves all to the first one. */
function show({ colours, mode, texture, isOne }) {
  const N = 12;
  const points = [];
  for (let j = 0; j <= N; j += 1) for (let i = 0; i <= N; i += 1) points.push([i / N, j / N]);
  const triangles = [];
  for (let j = 0; j < N; j += 1) {
    for (let i = 0; i < N; i += 1) {
      const a = j * (N + 1) + i;
      triangles.push(a, a + 1, a + N + 2, a, a + N + 2, a + N + 1);
    }
  }
  const count = points.length;
  // Three quarters from the front, a little from above: where the camera stands at first.
  const out = [0.505, 0.257, 0.824];
  const right = [0.853, 0, -0.523];
  const up = [-0.134, 0.966, -0.219];
  const place = ([x, y]) => [0, 1, 2].map((k) => 1.4 * ((x - 0.5) * right[k] + (y - 0.5) * up[k]));
  const positions = points.flatMap(place);
  const normals = points.flatMap(() => out);
  const charts = points.flat();
  const first = ([x]) => (isOne ? 1 : Math.min(1, Math.max(0, 2 - 3 * x)));
  const weights = [points.flatMap((p) => [first(p), 1 - first(p), -1, -1]), points.flatMap((p) => [1 - first(p), first(p), -1, -1])];
  const patch = (color) => ({ color, area_fraction: 1, anchor: [0.5, 0.5], flipped: 0, has_chart: true });
  const twice = (list) => [...list, ...list];
  window.layersViewer.set_scene({
    positions: Float32Array.from(positions),
    normals: Float32Array.from(normals),
    charts: Float32Array.from(charts),
    values: new Float32Array(),
    vertex_patches: new Uint32Array(count),
    triangles: Uint32Array.from(triangles),
    triangle_faces: Uint32Array.from(triangles.slice(0, triangles.length / 3).map((_, i) => i)),
    rims: new Uint32Array(),
    rim_partners: new Uint32Array(),
    patches: [patch(colours[0])],
    sheet: [0, 0, 1, 1],
    field: null,
    mark_points: new Float32Array(),
    mark_segments: new Float32Array(),
    cone_points: new Float32Array(),
    cone_angles: new Float32Array(),
    cone_charts: new Uint32Array(),
    is_folded: false,
    revision: 0,
    layers: {
      positions: Float32Array.from(twice(positions)),
      normals: Float32Array.from(twice(normals)),
      uvs: Float32Array.from(twice(charts)),
      places: Float32Array.from([...charts, ...points.flatMap(([x, y]) => [x + 1.1, y])]),
      weights: Float32Array.from(weights.flat()),
      vertex_charts: Uint32Array.from({ length: 2 * count }, (_, i) => (i < count ? 0 : 1)),
      triangles: Uint32Array.from([...triangles, ...triangles.map((v) => v + count)]),
      rims: new Uint32Array(),
      charts: colours.map(patch),
      sheet: [0, 0, 2.1, 1],
    },
  });
  window.layersViewer.set_layers(mode);
  window.layersViewer.set_texture(texture, 0);
  window.layersViewer.draw();
}

const pictures = {};

for (const renderer of RENDERERS) {
  describe(`overlapping charts with ${renderer.name}`, { timeout: 600_000 }, () => {
    let browser, page;
    before(async () => {
      browser = await open(renderer);
      page = new Page(browser.page);
      await page.visit(`${PAGE}?renderer=${renderer.query}&run=0`);
      await browser.page.evaluate(make, renderer.name);
    });
    after(() => browser?.close());

    async function picture(label, options) {
      await browser.page.evaluate(show, { colours: [0, 4], mode: "blended", texture: "none", isOne: false, ...options });
      await browser.page.waitForTimeout(300);
      return decodePng(await page.canvas(label).screenshot());
    }
    /** The colours along the row in the middle, as far as the square goes. */
    const row = ({ rgb, width, height }) =>
      Array.from({ length: 180 }, (_, i) => [0, 1, 2].map((c) => rgb[3 * ((height >> 1) * width + 60 + i) + c]));

    it("adds shares of one colour up to what one chart alone would be", async () => {
      for (const texture of ["none", "checkerboard", "marble"]) {
        const alone = await picture("Layers surface", { colours: [2, 2], texture, isOne: true });
        const both = await picture("Layers surface", { colours: [2, 2], texture });
        // Shares are rounded to eight bits before they are added.
        assert.ok(difference(alone, both) < 0.6, `${texture}: ${difference(alone, both)}`);
      }
    });

    it("passes from one colour to the other where it is blended, at once where it is cut", async () => {
      const step = (colours) => Math.max(...colours.slice(1).map((c, i) => Math.max(...c.map((x, k) => Math.abs(x - colours[i][k])))));
      const blended = row(await picture("Layers surface"));
      const hard = row(await picture("Layers surface", { mode: "hard" }));
      assert.ok(step(blended) < 12, `blended in steps of up to ${step(blended)}`);
      assert.ok(step(hard) > 30, `cut in steps of up to ${step(hard)}`);
      // Neither has a dark gap, and both end in the same colours.
      for (const colours of [blended, hard]) {
        assert.ok(colours.every((c) => Math.max(...c) > 100), "a gap");
        assert.ok([0, 1, 2].every((k) => Math.abs(colours[0][k] - blended[0][k]) <= 3 && Math.abs(colours.at(-1)[k] - blended.at(-1)[k]) <= 3));
      }
      const distance = Math.max(...[0, 1, 2].map((k) => Math.abs(blended[0][k] - blended.at(-1)[k])));
      assert.ok(distance > 40, `the ends differ by ${distance}`);
      await screenshot(browser.page, `${renderer.name}-layers`);
    });

    it("shows the charts side by side, fading with their weights", async () => {
      const pieces = await picture("Layers flat", { mode: "pieces" });
      const blended = await picture("Layers flat");
      const hard = await picture("Layers flat", { mode: "hard" });
      pictures[renderer.name] = { blended, hard };
      assert.ok(difference(pieces, blended) > 3 && difference(blended, hard) > 1);
    });
  });
}

describe("overlapping charts of both backends", () => {
  it("are alike", (t) => {
    for (const mode of ["blended", "hard"]) {
      const [one, other] = RENDERERS.map(({ name }) => pictures[name]?.[mode]);
      assert.ok(one && other, "a backend has drawn nothing");
      const mean = difference(one, other);
      t.diagnostic(`${mode}: mean difference ${mean.toFixed(2)} of 255`);
      assert.ok(mean <= ALIKE, `${mode}: they differ by ${mean.toFixed(2)} of 255; ${ALIKE} are allowed`);
    }
  });
});
