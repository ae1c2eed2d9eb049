// Phase fields and developable patches as a person meets them: run, look at a segment, divide further, sew pieces, go on with the
// cut flow, take files away. The engine is the same under either backend; the views of layers are tested beside the textures.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { RENDERERS, screenshot } from "./chromium.mjs";
import { ellipsoid, parseObj, uvAreas } from "./meshes.mjs";
import { begin } from "./page.mjs";

/** 642 vertices. */
const MESH = ellipsoid(3);
const [renderer] = RENDERERS;

describe("segmentations", { timeout: 600_000 }, () => {
  let browser, page;
  before(async () => {
    ({ browser, page } = await begin(renderer, { name: "ellipsoid.obj", mesh: MESH }));
  });
  after(() => browser?.close());

  const tab = (name) => browser.page.getByRole("tab", { name, exact: true });
  const label = (name) => browser.page.getByLabel(name, { exact: true });
  const items = () => browser.page.getByRole("treeitem");
  const pieces = () => browser.page.getByRole("table", { name: "Pieces" }).locator("tbody tr").count();
  /** Waits until the status line says the same for a while, and that it converged: a run may begin a moment after what asks for it. */
  const resting = async () => {
    const line = browser.page.getByRole("status");
    const look = async () => {
      const before = await line.textContent();
      await browser.page.waitForTimeout(600);
      return before === (await line.textContent()) ? before : "";
    };
    await page.until("a run that has come to rest", look, (text) => /^Converged after \d+ steps/.test(text));
  };

  it("divides a mesh in four, and shows the tree", async () => {
    await tab("Phase field").click();
    await page.status(/^Ready/);
    await page.press("Run");
    await resting();
    assert.equal(await items().count(), 7);
    assert.equal(await pieces(), 4);
    const shares = await items().locator(".muted").allTextContents();
    assert.deepEqual(shares.slice(1, 3).map(parseFloat), [50, 25]);
    await screenshot(browser.page, "segments");
  });

  it("shows the segment that is clicked", async () => {
    await items().nth(1).click();
    await browser.page.waitForFunction(() => document.querySelector("select.overlay").value === "weight");
    assert.equal(await items().nth(1).getAttribute("aria-selected"), "true");
    assert.match(await browser.page.locator(".hierarchy .fine").textContent(), /^Segment 1, 50\.0\s% of the area/);
  });

  it("divides further when more levels are asked for, and takes it back", async () => {
    await label("Levels").fill("3");
    await label("Levels").press("Enter");
    await browser.page.waitForFunction(() => document.querySelectorAll("[role=treeitem]").length === 15);
    await resting();
    await page.press("Undo");
    await browser.page.waitForFunction(() => document.querySelectorAll("[role=treeitem]").length === 7);
  });

  it("blends textures over the overlaps when asked to", async () => {
    await label("Atlas").selectOption("blended");
    await browser.page.waitForFunction(() => document.querySelector("select.overlay").value === "pieces");
    await label("Texture").selectOption("marble");
    await page.drawn();
    await screenshot(browser.page, "atlas");
    await label("Atlas").selectOption("pieces");
  });

  it("exports segments as every other cut", async () => {
    const flat = parseObj(await page.export("UV mesh (OBJ)"));
    assert.deepEqual(flat.vertices.slice(0, 642), parseObj(MESH).vertices);
    assert.ok(uvAreas(flat).every((area) => area > 0));
    const report = JSON.parse(await page.export("Report (JSON)"));
    assert.equal(report.phasefield.components, 4);
  });

  it("goes on with the cut flow from there", async () => {
    await page.press("Improve by the cut flow");
    await browser.page.waitForFunction(() => document.documentElement.dataset.method === "cutflow");
    assert.equal(await pieces(), 4);
    await page.press("Step");
    await page.status(/^Paused at step 1\b/);
  });

  it("parts a mesh into patches that nearly lie flat, stage by stage", async () => {
    await tab("Developable patches").click();
    await page.status(/^Ready/);
    // With the usual ten per cent an ellipsoid is one piece with darts.
    await label("Area change at most").fill("2");
    await label("Area change at most").press("Enter");
    await page.press("Run");
    await resting();
    const stages = browser.page.getByRole("table", { name: "Stages" }).locator("tbody tr");
    const [first, , merged] = await stages.locator("td:nth-of-type(1)").allTextContents();
    assert.ok(Number(merged) < Number(first), `${first} pieces became ${merged}`);
    assert.equal(await pieces(), Number(merged));
    await screenshot(browser.page, "developable");
    const report = JSON.parse(await page.export("Report (JSON)"));
    assert.ok(report.develop.patches.every((patch) => patch.area_change_abs <= 0.1 && !patch.overlap));
  });

  it("keeps two pieces apart, and takes that back", async () => {
    const before = await pieces();
    await label("First piece").fill("1");
    await label("Second piece").fill("2");
    await page.press("Keep apart");
    await resting();
    assert.ok((await pieces()) >= 2, `${before} pieces`);
    await page.press("Undo");
    await page.until("the pieces from before", pieces, (count) => count === before);
    assert.match(await browser.page.getByRole("button", { name: "Redo" }).getAttribute("title"), /keep two pieces apart/);
  });

  it("merges pieces in both images of the mirror plane that is ticked, one at a time", async () => {
    const section = browser.page.locator("#settings details", { has: browser.page.locator(".symmetry") });
    if (!(await section.evaluate((node) => node.open))) await section.locator("summary").click();
    assert.match(await section.locator(".symmetry .fine").textContent(), /pieces can be merged in both images/);
    await section.getByRole("button", { name: /^(Find symmetries|Search again)$/ }).click();
    const boxes = browser.page.getByRole("list", { name: "Symmetries" }).getByRole("checkbox");
    await page.until("mirror planes are found", () => boxes.count(), (count) => count >= 3);
    for (const i of [0, 1]) {
      await boxes.nth(i).check();
      await resting();
      const ticked = await boxes.evaluateAll((list) => list.map((box) => box.checked).indexOf(true));
      assert.equal(ticked, i);
      assert.equal(await boxes.evaluateAll((list) => list.filter((box) => box.checked).length), 1);
    }
    await screenshot(browser.page, "developable-symmetry");
    const report = JSON.parse(await page.export("Report (JSON)"));
    assert.equal(report.develop.symmetry.length, 1);
    // The cut flow has symmetries of its own.
    await tab("Cut flow").click();
    await page.until("its own boxes", () => boxes.evaluateAll((list) => list.filter((box) => box.checked).length), (count) => count === 0);
  });
});
