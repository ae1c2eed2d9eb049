// What stands in and over the views: the texture and its size, legends, the ruler, the warning over the charts, notices.
// Textures are drawn by shaders, so they are compared between the backends; everything else is looked at under one.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { PAGE, RENDERERS, screenshot } from "./chromium.mjs";
import { ellipsoid } from "./meshes.mjs";
import { begin } from "./page.mjs";
import { decodePng, difference } from "./pixels.mjs";

const MESH = ellipsoid(3);
const CANVASES = ["Surface view", "Flattened view"];
const TEXTURES = ["none", "checkerboard", "grid", "circles", "spots", "marble"];
/** Sixteen pixels squared: stripes of pure green and white. */
const STRIPES = Buffer.from(
  "iVBORw0KGgoAAAANSUhEUgAAABAAAAAQCAIAAACQkWg2AAAAGUlEQVR42mNg+M8AR/+RAE7xUQ2jGoavBgAmef4Qq9bxhQAAAABJRU5ErkJggg==",
  "base64",
);
/** Mean difference of the backends' pictures, of 255: see page.test.mjs. */
const ALIKE = 3;
/** Desktop, a small laptop, a phone. */
const SIZES = [[1440, 900], [1024, 768], [390, 844]];
/** `{ number, unit }` of what the legend says of a cell. */
const cellOf = (text) => {
  const [, number, unit] = /^(?:checks of|grid of|circles every) ([\d.\u202f]+)\u00a0(mm|cm|m|inch)$/.exec(text) ?? [];
  assert.ok(number, `“${text}” says no size`);
  return { number: Number(number.replaceAll("\u202f", "")), unit };
};

const pictures = {};

for (const renderer of RENDERERS) {
  describe(`the texture with ${renderer.name}`, { timeout: 600_000 }, () => {
    let browser, page;
    before(async () => {
      ({ browser, page } = await begin(renderer, { name: "ellipsoid.obj", mesh: MESH, pixels: 1 }));
      await page.press("Step");
      await page.status(/^Paused at step 1\b/);
    });
    after(() => browser?.close());

    const choice = () => browser.page.getByLabel("Texture", { exact: true });
    const weave = () => browser.page.locator(".flat .legend .weave");
    const isPressed = (name) => browser.page.getByRole("button", { name, exact: true }).getAttribute("aria-pressed");
    async function picture(label) {
      await browser.page.mouse.move(5, 5);
      await page.drawn();
      return decodePng(await page.canvas(label).screenshot());
    }

    it("is a checkerboard at first, and each choice is drawn in both views", async () => {
      assert.equal(await choice().inputValue(), "checkerboard");
      assert.equal(await isPressed("Checkerboard"), "true");
      pictures[renderer.name] = {};
      for (const name of TEXTURES) {
        await choice().selectOption(name);
        for (const label of CANVASES) pictures[renderer.name][`${name}, ${label}`] = await picture(label);
        await screenshot(browser.page, `${renderer.name}-texture-${name}`);
      }
      for (const label of CANVASES) {
        for (const [i, one] of TEXTURES.entries()) {
          for (const other of TEXTURES.slice(i + 1)) {
            const [a, b] = [one, other].map((name) => pictures[renderer.name][`${name}, ${label}`]);
            // The faintest, lines over a third of the picture, change it by a tenth of a step in the mean.
            assert.ok(difference(a, b) > 0.1, `${label}: ${one} and ${other} look alike`);
          }
        }
      }
    });

    it("can be an image of one's own, chosen or dropped, and what is none is refused", async () => {
      await choice().selectOption("none");
      const plain = await picture(CANVASES[0]);
      const input = browser.page.getByLabel("Texture image", { exact: true });
      await input.setInputFiles({ name: "stripes.png", mimeType: "image/png", buffer: STRIPES });
      await page.until("the image as texture", () => choice().inputValue(), (name) => name === "image");
      for (const label of CANVASES) {
        const { rgb } = await picture(label);
        // Pure green is in the image and nowhere else on the page; light may darken it.
        let green = 0;
        for (let i = 0; i < rgb.length; i += 3) green += rgb[i + 1] > 80 && rgb[i] < 70 && rgb[i + 2] < 70 ? 1 : 0;
        assert.ok(green > 500, `${label}: ${green} green pixels`);
      }
      await screenshot(browser.page, `${renderer.name}-texture-image`);
      await choice().selectOption("none");
      assert.ok(difference(plain, await picture(CANVASES[0])) < 0.1, "none is what it was");
      await choice().selectOption("image");
      assert.equal(await choice().inputValue(), "image", "an image that is there is shown at once");
      await choice().selectOption("none");
      const transfer = await browser.page.evaluateHandle((code) => {
        const transfer = new DataTransfer();
        const bytes = Uint8Array.from(atob(code), (letter) => letter.charCodeAt(0));
        transfer.items.add(new File([bytes], "stripes.png", { type: "image/png" }));
        return transfer;
      }, STRIPES.toString("base64"));
      await browser.page.dispatchEvent("body", "drop", { dataTransfer: transfer });
      await page.until("the dropped image as texture", () => choice().inputValue(), (name) => name === "image");
      await input.setInputFiles({ name: "notes.png", mimeType: "image/png", buffer: Buffer.from("no image") });
      const [what, , todo] = await page.error();
      assert.match(what, /^notes\.png is no image/);
      assert.match(todo, /PNG/);
      await page.press("Dismiss");
      assert.equal(await choice().inputValue(), "image");
      await choice().selectOption("checkerboard");
    });

    it("is drawn over a field as well", async () => {
      await browser.page.getByLabel("Flattened overlay", { exact: true }).selectOption("u");
      for (const label of CANVASES) {
        await choice().selectOption("none");
        const plain = await picture(label);
        for (const name of TEXTURES.slice(1)) {
          await choice().selectOption(name);
          assert.ok(difference(plain, await picture(label)) > 0.1, `${label}: ${name} is not seen on the field`);
        }
      }
      await screenshot(browser.page, `${renderer.name}-texture-field`);
      await browser.page.getByLabel("Flattened overlay", { exact: true }).selectOption("pieces");
    });

    if (renderer !== RENDERERS[0]) return;

    it("has cells of a round size, which is that on the screen", async () => {
      await choice().selectOption("checkerboard");
      const said = await page.until("the size of a cell", () => weave().textContent(), (text) => text !== "");
      const { number, unit } = cellOf(said);
      assert.equal(unit, "mm");
      assert.ok([1, 2, 5].includes(Number(number.toExponential(0)[0])), `${number} is not round`);
      const rule = browser.page.locator(".flat .rule");
      const { width } = await rule.locator("i").boundingBox();
      const pixels = (number * width) / Number.parseFloat(await rule.locator("b").textContent());
      const { rgb, width: across, height } = await picture("Flattened view");
      // The runs of one colour along each row; those between two others of the same pair are cells seen whole.
      const runs = [];
      for (let y = 0; y < height; y += 1) {
        let [start, before] = [0, 0];
        for (let x = 1; x <= across; x += 1) {
          const at = 3 * (y * across + x);
          const isEnd = x === across || [0, 1, 2].some((c) => Math.abs(rgb[at + c] - rgb[at - 3 + c]) > 2);
          if (!isEnd) continue;
          if (x - start > 3 && x - start < 3 * pixels && before > 0) runs.push(x - start);
          [start, before] = [x, x - start];
        }
      }
      runs.sort((a, b) => a - b);
      const median = runs[runs.length >> 1];
      // A border falls inside a pixel, which then has a third colour.
      assert.ok(Math.abs(median - pixels) <= 1.5, `cells are ${median} pixels wide in place of ${pixels.toFixed(1)}`);
    });

    it("grows with the model, and is told in the unit of the page", async () => {
      const before = cellOf(await weave().textContent());
      await page.openMeshSection();
      const size = page.meshSection("Size");
      const [height] = (await page.sizes()).slice(1);
      await size.getByLabel("Height (y)", { exact: true }).fill(String(100 * height));
      await browser.page.keyboard.press("Enter");
      const after = cellOf(await page.until("a larger cell", () => weave().textContent(), (text) => cellOf(text).number > before.number));
      assert.ok(Math.abs(after.number / before.number - 100) < 1e-6, `${before.number} and ${after.number}`);
      await size.getByLabel("Unit", { exact: true }).selectOption("in");
      await page.until("inches", () => weave().textContent(), (text) => cellOf(text).unit === "inch");
      assert.match(await browser.page.locator(".flat .rule").textContent(), /^[\d.\u202f]+ inch$/);
      assert.match(await browser.page.locator(".flat .said").textContent(), /× .* inch/);
    });

    it("comes and goes with its button and with C, and is remembered", async () => {
      await choice().selectOption("grid");
      assert.equal(await isPressed("Grid"), "true");
      await page.press("Grid");
      assert.equal(await choice().inputValue(), "none");
      await page.until("no size", () => weave().isVisible(), (isVisible) => !isVisible);
      await page.canvas("Flattened view").focus();
      await browser.page.keyboard.press("c");
      assert.equal(await choice().inputValue(), "grid");
      await browser.page.keyboard.press("c");
      await page.visit(`${PAGE}?renderer=${renderer.query}&run=0`);
      assert.equal(await choice().inputValue(), "none");
      await page.press("Grid");
      await page.until("the grid", () => weave().textContent(), (text) => text.startsWith("grid of"));
    });

    it("has nothing to complain of in the browser's console", () => {
      assert.deepEqual(browser.troubles, []);
    });
  });
}

describe("textures of both backends", () => {
  it("are alike", (t) => {
    for (const label of CANVASES) {
      for (const name of TEXTURES) {
        const [one, other] = RENDERERS.map((renderer) => pictures[renderer.name]?.[`${name}, ${label}`]);
        assert.ok(one && other, "a backend has drawn nothing");
        const mean = difference(one, other);
        t.diagnostic(`${label}, ${name}: mean difference ${mean.toFixed(2)} of 255`);
        assert.ok(mean <= ALIKE, `${label}, ${name}: they differ by ${mean.toFixed(2)} of 255; ${ALIKE} are allowed`);
      }
    }
  });
});

describe("what stands over the views", { timeout: 600_000 }, () => {
  let browser, page;
  before(async () => {
    // Letters are as wide as they are only where every pixel is drawn.
    ({ browser, page } = await begin(RENDERERS[0], { pixels: 1 }));
  });
  after(() => browser?.close());

  const alarm = () => browser.page.locator("#alarm");
  /** Says as the engine does how many triangles are turned over and how often charts overlap. */
  async function tell(flipped, overlaps) {
    const [worker] = browser.page.workers();
    await worker.evaluate(([flipped, overlaps]) => {
      const row = (id, label, now) => ({ id, label, unit: "", now, start: 0 });
      const rows = [row("pieces", "Pieces", 2), row("flipped", "Flipped triangles", flipped), row("overlaps", "Overlaps", overlaps)];
      const piece = (patch, flipped) => ({ patch, color: patch, area_fraction: 0.5, seam_length: 1, rms_u: 0.1, flipped, overlaps: 0, has_chart: true, note: flipped > 0 ? "Turned over" : "" });
      const pattern = { width: 130, height: 284, unit: "mm", filled: 0.3, unit_length: 33.5, overlaps };
      self.postMessage({ type: "events", events: [{ type: "measures", rows, pieces: [piece(0, 0), piece(1, flipped)], pattern, note: null }], spent: 0 });
    }, [flipped, overlaps]);
  }

  it("warns over the charts while they must not be cut, and shows where", async () => {
    assert.equal(await alarm().textContent(), "");
    for (const [flipped, overlaps, text] of [
      [3, 2, "3 triangles turned over, 2 overlaps in piece 2: not safe to cut yet"],
      [1, 0, "1 triangle turned over in piece 2: not safe to cut yet"],
      [0, 1, "1 overlap: not safe to cut yet"],
    ]) {
      await tell(flipped, overlaps);
      await page.until("the warning", () => alarm().locator("span").textContent(), (said) => said === text);
    }
    assert.equal(await alarm().getAttribute("aria-live"), "polite");
    await tell(3, 0);
    await page.until("a row that is marked", () => browser.page.locator("tr.fault").count(), (count) => count === 1);
    await alarm().getByRole("button").click();
    assert.equal(await browser.page.evaluate(() => document.activeElement.id), "measures");
    assert.equal(await browser.page.locator("#measures tr.on th").textContent(), "Flipped triangles");
    assert.equal(await browser.page.locator("#pieces tr.on").count(), 1);
    assert.equal(await page.measure("Flipped triangles"), 3);
    await tell(0, 0);
    await page.until("no warning", () => alarm().textContent(), (text) => text === "");
    assert.equal(await browser.page.locator("tr.fault").count(), 0);
  });

  for (const method of ["Cut flow", "Cones"]) {
    for (const [width, height] of SIZES) {
      it(`keeps ${method} readable at ${width} pixels: nothing is covered or cut off`, async () => {
        await browser.page.setViewportSize({ width, height });
        const tab = browser.page.getByRole("tablist", { name: "Method" }).getByRole("tab", { name: method, exact: true });
        if ((await tab.getAttribute("aria-selected")) !== "true") {
          await tab.click();
          await page.status(/^(Ready|Paused|Converged)/);
          await page.press("Step");
          await page.status(/^(Paused|Converged)/);
        }
        for (const field of ["u", "area", "pieces"]) {
          await browser.page.getByLabel("Flattened overlay", { exact: true }).selectOption(field);
          await tell(3, 2);
          await browser.page.evaluate(() => {
            const toast = document.getElementById("toast");
            toast.textContent = "The mesh is coarse where the cones are: an angle may be spread over several vertices. Refine it under Prepare for better places.";
            toast.hidden = false;
          });
          await browser.page.waitForTimeout(800);
          await screenshot(browser.page, `views-${method.replace(" ", "-")}-${field}-${width}`);
          const problems = await browser.page.evaluate(overlapping);
          assert.deepEqual(problems, [], `with ${field}`);
        }
        await browser.page.evaluate(() => (document.getElementById("toast").hidden = true));
      });
    }
  }

  it("tells the change of area in per cent", async () => {
    await browser.page.setViewportSize({ width: 1440, height: 900 });
    await browser.page.getByLabel("Flattened overlay", { exact: true }).selectOption("area");
    const legend = browser.page.locator(".flat .said");
    const text = await page.until("the legend", () => legend.textContent(), (text) => text.includes("Area distortion"));
    assert.match(text, /Area distortion change of area/);
    assert.match(text, /max [+−][\d.\u202f]+\u202f%/);
    assert.doesNotMatch(text, /log/);
  });

  it("has nothing to complain of in the browser's console", () => {
    assert.deepEqual(browser.troubles, []);
  });
});

/** Runs in the page: pairs of what must be read at once that share a place, and texts that do not fit. */
function overlapping() {
  const problems = [];
  const parts = [".surface .legend > *", ".flat .said > *", ".legend .title", ".flat .weave", ".flat .rule", "#alarm button", "#toast", "#hint", ".surface .head > *", ".flat .head > *", "#status", "#note"];
  const shown = parts.flatMap((name) => [...document.querySelectorAll(name)]
    .filter((node) => node.checkVisibility({ opacityProperty: true }) && node.textContent.trim() !== "" && node.clientWidth > 0)
    .map((node) => ({ name: `${name} “${node.textContent.trim().slice(0, 40)}”`, node, box: node.getBoundingClientRect() })));
  shown.forEach(({ name, node, box }, i) => {
    for (const other of shown.slice(i + 1)) {
      if (node.contains(other.node) || other.node.contains(node)) continue;
      const [x, y] = [Math.min(box.right, other.box.right) - Math.max(box.left, other.box.left), Math.min(box.bottom, other.box.bottom) - Math.max(box.top, other.box.top)];
      if (x > 1 && y > 1) problems.push(`${name} and ${other.name} cover each other`);
    }
    if (box.left < 0 || box.right > innerWidth + 1) problems.push(`${name} leaves the window`);
    const isText = !name.includes(".head");
    if (isText && (node.scrollWidth > node.clientWidth + 1 || node.scrollHeight > node.clientHeight + 1)) problems.push(`${name} is cut off`);
  });
  return problems;
}
