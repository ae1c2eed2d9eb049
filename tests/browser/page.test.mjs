// A person opens the page, drops a mesh, runs the cut, pauses, steps and takes the files home. What is drawn is looked at under each
// backend, the rest under one.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { PAGE, RENDERERS, open, screenshot } from "./chromium.mjs";
import { ellipsoid, parseObj, surfaceArea, uvAreas } from "./meshes.mjs";
import { Page } from "./page.mjs";
import { decodePng, difference, variety } from "./pixels.mjs";

/** 10 242 vertices: big enough for a run that can be paused, and the size that the page is made for. */
const MESH = ellipsoid(5);
const CANVASES = ["Surface view", "Flattened view"];

/** Mean difference of the backends' pictures, of 255. Edges are smoothed differently; a wrong colour space shows as 10 to 40. */
const ALIKE = 3;

/** Files that cannot be read as a mesh, by what is wrong with them. */
const BAD_FILES = {
  "page.obj": "<!doctype html>\n<title>404 Not Found</title>\n",
  "no-faces.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
  "out-of-range.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
  "not-finite.obj": "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n",
};

/** By backend, the two canvases after the same two steps. */
const pictures = {};

for (const renderer of RENDERERS) {
  describe(renderer.name, { timeout: 600_000 }, () => {
    let browser, page;
    before(async () => {
      browser = await open(renderer);
      page = new Page(browser.page);
    });
    after(() => browser?.close());

    it("shows a running example as soon as it is opened", async (t) => {
      const start = performance.now();
      await page.page.goto(`${PAGE}?renderer=${renderer.query}`);
      await page.status(/^(Running step [1-9]|Converged)/);
      t.diagnostic(`first running step ${((performance.now() - start) / 1000).toFixed(1)} s after opening`);
      // The engine may be faster than the graphics.
      await page.page.waitForSelector("html[data-renderer]", { state: "attached" });
      assert.equal(await page.page.locator("html").getAttribute("data-renderer"), renderer.name);
      await screenshot(page.page, `${renderer.name}-example`);
    });

    it("opens a dropped file and is ready to cut it", async () => {
      await page.dropFile("ellipsoid.obj", MESH);
      await page.status(/^Ready/);
      assert.ok((await page.measure("Pieces")) >= 2, "the initial cut has two pieces at least");
    });

    it("takes one step at a time", async () => {
      for (const step of [1, 2]) {
        await page.press("Step");
        await page.status(new RegExp(`^Paused at step ${step}\\b`));
      }
    });

    it("draws the surface and its pieces", async () => {
      await page.drawn();
      pictures[renderer.name] = {};
      for (const label of CANVASES) {
        const picture = decodePng(await page.canvas(label).screenshot());
        const { colours, covered } = variety(picture);
        assert.ok(colours > 50, `${label} has ${colours} colours only`);
        assert.ok(covered > 0.1, `${label} is covered to ${(100 * covered).toFixed(1)} % only`);
        pictures[renderer.name][label] = picture;
      }
      await screenshot(page.page, `${renderer.name}-two-steps`);
    });

    it("turns the surface with the pointer, and only the surface", async () => {
      const before = await Promise.all(CANVASES.map((label) => page.canvas(label).screenshot()));
      const { x, y, width, height } = await page.canvas("Surface view").boundingBox();
      await page.page.mouse.move(x + width / 2, y + height / 2);
      await page.page.mouse.down();
      await page.page.mouse.move(x + width / 2 + 120, y + height / 2 + 40, { steps: 4 });
      await page.page.mouse.up();
      await page.page.mouse.move(x + width / 2, 5);
      await page.drawn();
      const after = await Promise.all(CANVASES.map((label) => page.canvas(label).screenshot()));
      const [surface, flat] = CANVASES.map((_, i) => difference(decodePng(before[i]), decodePng(after[i])));
      assert.ok(surface > 1, `the surface has moved by ${surface.toFixed(2)} of 255 only`);
      assert.ok(flat < 0.1, `the flattened pieces have changed by ${flat.toFixed(2)} of 255`);
    });

    it("runs, and pauses where it is told to", async () => {
      await page.runUntil(/^Running step ([3-9]|\d\d)/);
      const [, step] = await page.status(/^Paused at step (\d+)/);
      await page.page.waitForTimeout(500);
      await page.status(new RegExp(`^Paused at step ${step}\\b`));
    });

    it("exports the surface as a picture", async () => {
      const { colours } = variety(decodePng(await page.exportBytes("Surface picture (PNG)")));
      assert.ok(colours > 50, `the picture has ${colours} colours only`);
    });

    it("fits a phone", async () => {
      await browser.page.setViewportSize({ width: 360, height: 740 });
      await page.drawn();
      await screenshot(browser.page, `${renderer.name}-phone`);
      const excess = await browser.page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.equal(excess, 0, "the page scrolls sideways");
      for (const label of CANVASES) {
        const { colours } = variety(decodePng(await page.canvas(label).screenshot()));
        assert.ok(colours > 50, `${label} has ${colours} colours only`);
      }
    });

    if (renderer !== RENDERERS[0]) {
      it("has nothing to complain of in the browser's console", () => assert.deepEqual(browser.troubles, []));
      return;
    }

    it("opens a file through the file input", async () => {
      await page.chooseFile("chosen.obj", MESH);
      await page.status(/^Loading|^Ready/);
      await page.status(/^Ready/);
      assert.match(await page.page.title(), /chosen\.obj/);
    });

    it("takes a step of it", async () => {
      await browser.page.setViewportSize({ width: 1280, height: 800 });
      await page.press("Step");
      await page.status(/^Paused at step 1\b/);
    });

    it("exports the mesh with UVs, its vertices untouched", async () => {
      const sent = parseObj(MESH);
      const got = parseObj(await page.export("UV mesh (OBJ)"));
      assert.deepEqual(got.vertices.slice(0, sent.vertices.length), sent.vertices);
      assert.ok(got.uvs.length > got.vertices.length, "vertices on a seam have several UVs");
      for (const { v, vt } of got.triangles) {
        assert.ok(v.every((i) => i in got.vertices), `there is no vertex for ${v}`);
        assert.ok(vt.every((i) => i in got.uvs), `there is no UV for ${vt}`);
      }
      assert.ok(got.uvs.flat().every((x) => x >= 0 && x <= 1), "UVs lie in the unit square");
      // Cutting splits triangles and moves nothing; what is left is the rounding of printed coordinates.
      assert.ok(Math.abs(surfaceArea(got) / surfaceArea(sent) - 1) < 1e-6, "the surface keeps its area");
      const flipped = uvAreas(got).filter((area) => area < 0).length;
      assert.equal(flipped, await page.measure("Flipped triangles"));
    });

    it("exports the pattern in millimetres, a closed path for each piece", async () => {
      const text = await page.export("Pattern (SVG)");
      const pattern = await page.page.evaluate(readPattern, text);
      assert.equal(pattern.error, null);
      const { width, height, viewBox, paths } = pattern;
      const sizes = [width, height].map((size) => /^([\d.]+)mm$/.exec(size)?.[1]);
      assert.deepEqual(viewBox.split(" "), ["0", "0", ...sizes], "one unit is one millimetre");
      assert.equal(paths.length, await page.measure("Pieces"));
      for (const path of paths) {
        assert.match(path.outline, /^M[^M]*Z$/i, "a path is one closed loop");
        const [x, y, right, bottom] = path.box;
        assert.ok(right - x > 1 && bottom - y > 1, "a piece is larger than a millimetre");
        assert.ok(x >= 0 && y >= 0 && right <= Number(sizes[0]) && bottom <= Number(sizes[1]), "a piece lies on the sheet");
      }
    });

    it("says of a bad file what is wrong, where, and what to do, and keeps the document", async () => {
      const before = await page.export("UV mesh (OBJ)");
      for (const [name, text] of Object.entries(BAD_FILES)) {
        await page.chooseFile(name, text);
        const parts = await page.error();
        assert.equal(parts.length, 3, `${name}: ${parts.join(" | ")}`);
        await page.status(/^Error: /);
        await screenshot(page.page, `${renderer.name}-${name.replace(".obj", "")}`);
        await page.press("Dismiss");
        await page.page.getByRole("alert").waitFor({ state: "hidden" });
      }
      assert.ok((await page.export("UV mesh (OBJ)")) === before, "the document is as it was");
      await page.press("Step");
      await page.status(/^Paused at step \d+/);
    });

    it("brings the mesh back when the solver dies", async () => {
      await page.endSolver();
      // From what was kept of the session: with the cut as it was.
      await page.status(/^Paused at step \d+/);
      assert.match(await browser.page.title(), /chosen\.obj/);
      await page.press("Step");
      await page.status(/^Paused at step \d+/);
    });

    it("goes back to the start, and undoes that", async () => {
      await page.press("Reset");
      await page.status(/^Ready/);
      await page.press("Undo");
      await page.status(/^Paused at step \d+/);
    });

    it("has nothing to complain of in the browser's console", () => {
      assert.deepEqual(browser.troubles, []);
    });
  });
}

describe("both backends", () => {
  for (const label of CANVASES) {
    it(`draw the ${label.toLowerCase()} alike`, (t) => {
      const [one, other] = RENDERERS.map(({ name }) => pictures[name]?.[label]);
      assert.ok(one && other, "a backend has drawn nothing");
      const mean = difference(one, other);
      t.diagnostic(`mean difference ${mean.toFixed(2)} of 255`);
      assert.ok(mean <= ALIKE, `they differ by ${mean.toFixed(2)} of 255 in the mean; ${ALIKE} are allowed`);
    });
  }
});

/** Runs in the page, which has the reader of XML and of paths: what a pattern holds, its outlines in `paths`. */
function readPattern(text) {
  const parsed = new DOMParser().parseFromString(text, "image/svg+xml");
  const error = parsed.querySelector("parsererror")?.textContent ?? null;
  const svg = document.importNode(parsed.documentElement, true);
  document.body.append(svg);
  const paths = [...svg.querySelectorAll("#cut path")].map((path) => {
    const { x, y, width, height } = path.getBBox();
    return { outline: path.getAttribute("d").trim(), box: [x, y, x + width, y + height] };
  });
  svg.remove();
  const [width, height, viewBox] = ["width", "height", "viewBox"].map((name) => svg.getAttribute(name));
  return { error, width, height, viewBox, paths };
}
