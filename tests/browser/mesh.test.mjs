// A person brings meshes as they come: in five formats, of any size, damaged, with poor triangles. Under one backend:
// what is drawn is compared in page.test.mjs.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { COARSE, PAGE, RENDERERS, open, screenshot } from "./chromium.mjs";
import { asGlb, asObj, asOff, asPly, asStl, ellipsoid, parseObj, withFlippedFaces, withTouchingHoles } from "./meshes.mjs";
import { Page } from "./page.mjs";
import { decodePng, difference } from "./pixels.mjs";

/** 642 vertices and 1 280 faces: enough for a cut, and quick to open many times. Its sides are as 2 to 1.6 to 1.2. */
const MESH = parseObj(ellipsoid(3));
const COUNTS = { vertices: MESH.vertices.length, faces: MESH.triangles.length };

/** The boxes show five digits. */
const isLength = (value, wanted) => Math.abs(value / wanted - 1) < 1e-4;
const areLengths = (values, wanted) => values.every((value, i) => isLength(value, wanted[i]));

const [renderer] = RENDERERS;

describe("meshes as they come", { timeout: 600_000 }, () => {
  let browser, page;
  before(async () => {
    browser = await open(renderer, COARSE);
    page = new Page(browser.page);
    await page.visit(`${PAGE}?renderer=${renderer.query}&run=0&sample=none`);
  });
  after(() => browser?.close());

  const button = (within, name) => within.getByRole("button", { name, exact: true });
  const opened = (name) => page.until(`${name} is open`, () => browser.page.title(), (title) => title.endsWith(name));

  const FORMATS = {
    "ellipsoid.obj": asObj(MESH),
    "ELLIPSOID.PLY": asPly(MESH),
    "ellipsoid.stl": asStl(MESH),
    "ellipsoid.off": asOff(MESH),
    "ellipsoid.glb": asGlb(MESH),
  };
  for (const [name, content] of Object.entries(FORMATS)) {
    it(`opens ${name}, dropped or chosen`, async () => {
      for (const way of ["dropFile", "chooseFile"]) {
        await page[way](name, content);
        await opened(name);
        await page.status(/^Ready$/);
        assert.deepEqual(await page.counts(), COUNTS);
        assert.ok((await page.measure("Pieces")) >= 1, "there is an initial cut");
        // The next one must be seen to arrive.
        await page.dropFile("between.obj", asObj(MESH));
        await opened("between.obj");
      }
    });
  }

  it("opens the first mesh among several files, and says so", async () => {
    await page.dropFiles({ "readme.txt": "hello", "Second.OBJ": asObj(MESH), "third.off": asOff(MESH) });
    await opened("Second.OBJ");
    await page.until("the notice", () => browser.page.locator("#toast").textContent(), (text) => /Second\.OBJ.*2 other files/.test(text));
  });

  it("keeps the proportions when one side is given its real length", async () => {
    await page.openMeshSection();
    const width = page.meshSection("Size").getByLabel("Width (x)", { exact: true });
    await width.fill("100");
    await width.press("Enter");
    await page.until("the other sides follow", () => page.sizes(), (sizes) => areLengths(sizes, [100, 80, 60]));
    const depth = page.meshSection("Size").getByLabel("Depth (z)", { exact: true });
    await depth.fill("120");
    await depth.blur();
    await page.until("any side can be given", () => page.sizes(), (sizes) => areLengths(sizes, [200, 160, 120]));
  });

  it("explains a size that is none, and keeps the one before", async () => {
    const size = page.meshSection("Size");
    for (const text of ["abc", "-3", "0"]) {
      const height = size.getByLabel("Height (y)", { exact: true });
      await height.fill(text);
      await height.press("Enter");
      await page.until("an explanation", () => size.locator(".problem").textContent(), (said) => said.includes("Height (y) must be a number above 0"));
      assert.ok(areLengths(await page.sizes(), [200, 160, 120]), "the size has changed");
    }
  });

  it("takes the size from the unit of the file", async () => {
    await page.meshSection("Size").getByLabel("Unit", { exact: true }).selectOption("cm");
    await page.until("two centimetres wide", () => page.sizes(), (sizes) => areLengths(sizes, [2, 1.6, 1.2]));
    assert.match(await page.meshSection("Size").textContent(), /Width \(x\)\s*cm/);
    await page.press("Undo");
    await page.until("the size before", () => page.sizes(), (sizes) => areLengths(sizes, [200, 160, 120]));
  });

  it("says what is waited for when the solver takes long, and waits no longer than one wants", async () => {
    const wait = browser.page.locator("#wait");
    const size = page.meshSection("Size");
    const unit = size.getByLabel("Unit", { exact: true });
    const width = size.getByLabel("Width (x)", { exact: true });
    /** Runs in the worker: keeps it busy. */
    const block = (milliseconds) => {
      const end = performance.now() + milliseconds;
      while (performance.now() < end);
    };
    const toUnit = () => unit.selectOption("cm");
    const toWidth = (value) => async () => {
      await width.fill(value);
      await width.press("Enter");
    };
    // Sizes that follow each other are one change for Undo.
    for (const [words, change, back] of [["Setting the unit", toUnit, () => page.press("Undo")], ["Setting the size", toWidth("150"), toWidth("200")]]) {
      const busy = browser.page.workers()[0].evaluate(block, 2000);
      await change();
      await page.until(words, () => wait.locator("span").textContent(), (text) => text === words);
      await wait.waitFor({ state: "visible" });
      await busy;
      await wait.waitFor({ state: "hidden" });
      await back();
      await page.until("the size before", () => page.sizes(), (sizes) => areLengths(sizes, [200, 160, 120]));
    }
    browser.page.workers()[0].evaluate(block, 30_000).catch(() => {});
    await toUnit();
    await wait.getByRole("button", { name: "Cancel", exact: true }).click();
    await browser.page.getByText("Setting the unit was cancelled.").waitFor();
    await page.status(/^Ready$/);
    await wait.waitFor({ state: "hidden" });
    assert.ok(areLengths(await page.sizes(), [200, 160, 120]), "the size has changed");
  });

  const DAMAGED = {
    "touching-holes.obj": asObj(withTouchingHoles(MESH)),
    "flipped.obj": asObj(withFlippedFaces(MESH)),
  };
  for (const [name, content] of Object.entries(DAMAGED)) {
    it(`shows what is wrong with ${name}, repairs it and cuts it`, async () => {
      await page.dropFile(name, content);
      await opened(name);
      await page.until("the section is open", () => page.meshSection().evaluate((section) => section.open), Boolean);
      for (const id of ["Run", "Step", "Reset"]) {
        const control = button(browser.page, id);
        assert.ok(await control.isDisabled(), `${id} is to wait for the repair`);
        assert.match(await control.getAttribute("title"), /Repair the mesh first/);
      }
      assert.ok(await browser.page.getByText("Repair the mesh first: see").isVisible(), "the flattened view says why it is empty");
      await screenshot(browser.page, `mesh-${name.replace(".obj", "")}`);

      const doctor = page.meshSection("Doctor");
      const show = button(doctor, "Show me").first();
      const pressed = () => show.getAttribute("aria-pressed");
      await show.click();
      await page.until("the finding is marked", pressed, (state) => state === "true");
      await show.click();
      await page.until("it is marked no longer", pressed, (state) => state === "false");

      await button(doctor, "Repair all").click();
      await page.until("it can be run", () => button(browser.page, "Run").isEnabled(), Boolean);
      assert.ok(await browser.page.getByText("Repair the mesh first: see").isHidden());
      await page.press("Run");
      await page.status(/^(Running step [1-9]|Converged)/);
      await page.press("Reset");
      await page.status(/^Ready$/);
    });
  }

  it("takes a repair back", async () => {
    const run = button(browser.page, "Run");
    const change = () => button(browser.page, "Undo").getAttribute("title");
    // Above the repair lie the run and the reset.
    for (let i = 0; i < 4 && (await run.isEnabled()); i += 1) {
      const last = await change();
      await page.press("Undo");
      await page.until("one change less", change, (title) => title !== last);
    }
    assert.ok(await run.isDisabled(), "the mesh is damaged again");
    await page.press("Redo");
    await page.until("it can be run", () => run.isEnabled(), Boolean);
  });

  it("marks a finding on a mesh that can be cut, and goes back to the pieces", async () => {
    await page.dropFile("open.obj", asObj({ ...MESH, triangles: MESH.triangles.slice(1) }));
    await opened("open.obj");
    await page.status(/^Ready$/);
    await page.openMeshSection();
    const picture = async () => {
      await browser.page.mouse.move(5, 5);
      // A notice from before would be in the picture.
      await browser.page.locator("#toast").waitFor({ state: "hidden" });
      // The newest scene may take a frame or two to reach the canvas.
      await browser.page.waitForTimeout(500);
      return decodePng(await page.canvas("Surface view").screenshot());
    };
    const pieces = await picture();
    const show = button(page.meshSection("Doctor"), "Show me").first();
    await show.click();
    await page.until("the finding is marked", () => show.getAttribute("aria-pressed"), (state) => state === "true");
    assert.ok(difference(pieces, await picture()) > 1, "the surface looks as before");
    await screenshot(browser.page, "mesh-finding");
    await button(browser.page, "Back to the pieces").click();
    await page.until("it is marked no longer", () => show.getAttribute("aria-pressed"), (state) => state === "false");
    assert.ok(difference(pieces, await picture()) < 0.5, "the pieces are back");
  });

  it("prepares the mesh with a tool, and undoes that", async () => {
    await page.dropFile("coarse.obj", asObj(MESH));
    await opened("coarse.obj");
    await page.openMeshSection();
    const tool = page.meshSection("Prepare").getByRole("group", { name: /subdiv/i }).first();
    await button(tool, "Apply").click();
    const { faces } = await page.until("there are other faces", () => page.counts(), ({ faces }) => faces !== COUNTS.faces);
    assert.ok(faces > COUNTS.faces, "subdivision makes more faces");
    await page.status(/^Ready$/);
    await page.press("Undo");
    await page.until("the faces before", () => page.counts(), ({ faces }) => faces === COUNTS.faces);
    await page.press("Redo");
    await page.until("the faces after", () => page.counts(), (counts) => counts.faces === faces);
  });

  it("keeps what was set for a tool when another mesh is opened", async () => {
    const box = (tool, label) => page.meshSection("Prepare").getByRole("group", { name: tool, exact: true }).getByLabel(label, { exact: true });
    const length = box("Remesh evenly", "Edge length");
    await length.fill("1.5");
    await length.press("Enter");
    const faces = await box("Reduce", "Faces").inputValue();
    await page.dropFile("coarser.obj", ellipsoid(2));
    await opened("coarser.obj");
    assert.equal(await length.inputValue(), "1.50", "what was set is gone");
    assert.notEqual(await box("Reduce", "Faces").inputValue(), faces, "what was not set follows the mesh");
    await page.press("Undo");
    await opened("coarse.obj");
    assert.equal(await length.inputValue(), "1.50", "what was set is gone");
  });

  it("brings repairs, preparation and size back when the solver dies", async () => {
    const counts = await page.counts();
    const width = page.meshSection("Size").getByLabel("Width (x)", { exact: true });
    await width.fill("100");
    await width.press("Enter");
    await page.until("the size is set", () => page.sizes(), ([x]) => isLength(x, 100));
    await page.endSolver();
    await page.until("the same mesh", () => page.counts(), (now) => now.faces === counts.faces);
    await page.until("the same size", () => page.sizes(), ([x]) => isLength(x, 100));
  });

  it("can be told not to make the first cut, and makes it when it is run", async () => {
    const [worker] = browser.page.workers();
    await page.dropFile("large.obj", ellipsoid(6));
    await opened("large.obj");
    await browser.page.locator("#wait button").evaluate((cancel) => cancel.click());
    // Cancel may come too late: then there is a cut.
    await page.status(/^Ready(: not cut yet)?$/);
    await page.until("nothing is waited for", () => browser.page.locator("#wait").isHidden(), Boolean);
    for (const id of ["Run", "Step"]) assert.ok(await button(browser.page, id).isEnabled(), `${id} is off`);
    await page.press("Step");
    await page.status(/^Paused at step 1\b/);
    assert.ok((await page.measure("Pieces")) >= 1, "there is a cut");
    assert.equal(browser.page.workers()[0], worker, "the solver was started again");
  });

  it("opens the Mesh section from the header, and with the keyboard", async () => {
    const summary = page.meshSection().locator("summary").first();
    await summary.focus();
    await summary.press("Enter");
    assert.ok(!(await page.meshSection().evaluate((section) => section.open)), "Enter closes it");
    await browser.page.locator("#mesh").getByRole("button").click();
    assert.ok(await page.meshSection().evaluate((section) => section.open), "the header opens it");
    assert.ok(await summary.evaluate((node) => node === document.activeElement), "the focus is there");
  });

  it("fits a phone", async () => {
    await page.dropFile("flipped.obj", DAMAGED["flipped.obj"]);
    await opened("flipped.obj");
    await browser.page.setViewportSize({ width: 360, height: 740 });
    await browser.page.waitForTimeout(500);
    await screenshot(browser.page, "mesh-phone");
    assert.equal(await browser.page.evaluate(() => document.documentElement.scrollWidth - innerWidth), 0, "the page scrolls sideways");
  });

  it("has nothing to complain of in the browser's console", () => {
    assert.deepEqual(browser.troubles, []);
  });
});
