// Compare as a person meets it: run methods on one mesh, see pictures and numbers side by side, show one again, keep another, take the table
// away. The engine's side of it is tested natively (tests/it/comparing.rs).

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, describe, it } from "node:test";

import { RENDERERS, screenshot } from "./chromium.mjs";
import { ellipsoid } from "./meshes.mjs";
import { begin } from "./page.mjs";

/** 162 vertices: every method ends within seconds. */
const MESH = ellipsoid(2);
const [renderer] = RENDERERS;
const METHODS = ["Cut flow", "Cones", "Phase field", "Developable patches"];

describe("comparing", { timeout: 600_000 }, () => {
  let browser, page, panel;
  before(async () => {
    ({ browser, page } = await begin(renderer, { name: "ellipsoid.obj", mesh: MESH }));
    panel = browser.page.getByRole("dialog", { name: "Compare", exact: true });
  });
  after(() => browser?.close());

  const results = () => panel.getByRole("list", { name: "Results" }).getByRole("listitem");
  const named = (name) => panel.getByRole("listitem", { name, exact: true });
  const inside = (name) => panel.getByRole("button", { name, exact: true });
  const press = (name) => inside(name).evaluate((button) => button.click());
  const rows = async () => {
    const lines = await panel.getByRole("table", { name: "Comparison", exact: true }).getByRole("row").all();
    return Promise.all(lines.map((line) => line.locator("th, td").allTextContents()));
  };
  const count = (n) => page.until("results", () => results().count(), (found) => found === n);
  /** What stands, as Measures says behind the panel. */
  const cutLength = () => browser.page.locator("#measures tr[data-id=cut_length] td").first().textContent();
  /** Whether both pictures of a card show something: not one colour. */
  const hasPictures = (name) =>
    named(name).evaluate((card) =>
      [...card.querySelectorAll("canvas")].map((canvas) => {
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        const colours = new Set();
        for (let i = 0; i < data.length; i += 4 * 97) colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
        return colours.size > 20;
      }),
    );

  it("opens, says what to do, and gives the focus back on Escape", async () => {
    await page.press("Compare");
    await panel.getByText("Nothing to compare yet.").waitFor();
    assert.equal(await browser.page.evaluate(() => document.activeElement.textContent), "Compare");
    assert.equal(await inside("Save table (CSV)").isDisabled(), true);
    await browser.page.keyboard.press("Escape");
    await panel.waitFor({ state: "hidden" });
    assert.equal(await browser.page.evaluate(() => document.activeElement.getAttribute("aria-label")), "Compare");
    await page.press("Compare");
  });

  it("runs the methods that are ticked, each with its picture, and leaves the document as it was", async () => {
    const before = await cutLength();
    await press("Compare methods");
    await page.status(/^Running step \d+: comparing, .*, \d of 4/);
    await page.status(/^Ready/);
    await count(4);
    for (const name of METHODS) assert.deepEqual(await hasPictures(name), [true, true], name);
    const [head, ...lines] = await rows();
    assert.deepEqual(head, ["Measure", ...METHODS]);
    const row = (label) => lines.find(([name]) => name === label).slice(1);
    for (const label of ["Pieces", "Cut length", "Area distortion", "Angle distortion", "Flipped triangles", "Overlaps", "Steps", "Time"]) {
      assert.ok(row(label).every((text) => /^\d/.test(text)), `${label}: ${row(label)}`);
    }
    assert.deepEqual(row("Hencky ∫u²").slice(1), ["–", "–", "–"]);
    assert.equal(row("Cut length").filter((text) => text.includes("shortest")).length, 1);
    assert.equal(await browser.page.getByRole("tab", { name: "Cut flow", exact: true }).getAttribute("aria-selected"), "true");
    assert.equal(await cutLength(), before);
    await screenshot(browser.page, "compare");
  });

  it("shows a result again as one change", async () => {
    await press("Show Cones");
    await page.status(/^Converged/);
    await named("Cones").getByText("Shown now").waitFor();
    assert.equal(await browser.page.getByRole("tab", { name: "Cones", exact: true }).getAttribute("aria-selected"), "true");
    assert.match(await browser.page.getByRole("button", { name: "Undo" }).getAttribute("title"), /show Cones/);
    await page.pressAtOnce("Undo");
    await page.status(/^Ready/);
    assert.equal(await panel.getByText("Shown now", { exact: true }).filter({ visible: true }).count(), 0);
  });

  it("keeps what stands under a name of one's own, and takes it away", async () => {
    await page.pressAtOnce("Step");
    await page.status(/^Paused at step 1/);
    await press("Keep this result");
    await count(5);
    await page.until("pictures", () => hasPictures("Cut flow 2"), (list) => list.length === 2 && list.every(Boolean));
    const name = named("Cut flow 2").getByLabel("Name", { exact: true });
    await name.fill('After 1 step, "mine"');
    await name.press("Enter");
    await named('After 1 step, "mine"').waitFor();
    const [download] = await Promise.all([browser.page.waitForEvent("download"), press("Save table (CSV)")]);
    assert.equal(download.suggestedFilename(), "ellipsoid-comparison.csv");
    const text = await readFile(await download.path(), "utf8");
    const lines = text.split("\r\n");
    assert.match(lines[0], /^Name,Method,Settings,Status,Steps,Time \(s\),Pieces,Cut length \(√A\),/);
    assert.equal(lines.length, 7);
    assert.ok(lines[5].startsWith('"After 1 step, ""mine""",Cut flow,,Paused at step 1,1,,'), lines[5]);
    await press('Remove After 1 step, "mine"');
    await count(4);
  });

  it("stops when it is told to, with what there is so far", async () => {
    for (const name of METHODS) await press(`Remove ${name}`);
    await count(0);
    await panel.getByLabel("Phase field", { exact: true }).uncheck();
    await panel.getByLabel("Developable patches", { exact: true }).uncheck();
    // Pressed as soon as it is there: the second run waits for the picture of the first, which nobody can be as fast as.
    await panel.evaluate((panel) => {
      const [stop, run] = ["Stop comparing", "Compare methods"].map((name) => [...panel.querySelectorAll("button")].find(({ textContent }) => textContent === name));
      new MutationObserver((_, observer) => {
        if (stop.hidden) return;
        observer.disconnect();
        stop.click();
      }).observe(stop, { attributes: true });
      run.click();
    });
    await page.until("the button that stops", () => inside("Compare methods").isEnabled(), Boolean);
    // The document that was put aside is back.
    await page.status(/^Paused at step 1$/);
    await inside("Stop comparing").waitFor({ state: "hidden" });
    assert.equal(await inside("Compare methods").isEnabled(), true);
    assert.ok((await results().count()) < 2, "not all that was asked for");
  });

  it("keeps what was found when the solver dies, and makes it again", async () => {
    const before = await results().count();
    await press("Compare methods");
    await count(before + 2);
    await page.status(/^Paused at step 1$/);
    const numbers = (await rows()).slice(1, 4).map((line) => line.map((text) => /^[^a-z]*/i.exec(text)[0]));
    await page.endSolver();
    await panel.getByText(/results from before stay to be read/).waitFor();
    await page.status(/^Paused at step 1$/);
    assert.equal(await results().count(), before + 2);
    assert.deepEqual(await hasPictures("Cones"), [true, true]);
    assert.deepEqual((await rows()).slice(1, 4).map((line) => line.map((text) => /^[^a-z]*/i.exec(text)[0])), numbers);
    assert.equal(await inside("Show Cones").isDisabled(), true);
    assert.equal(await inside("Save table (CSV)").isDisabled(), true);
    await press("Run them again");
    await page.until("all are back", () => inside("Save table (CSV)").isEnabled(), Boolean);
    await panel.getByText(/results from before/).waitFor({ state: "hidden" });
    await page.status(/^Paused at step 1$/);
    assert.equal(await results().count(), before + 2);
    assert.equal(await inside("Show Cones").isEnabled(), true);
    for (const name of ["Cut flow", "Cones"]) await press(`Remove ${name}`);
    await count(before);
  });

  it("fits a phone, cards scrolling sideways", async () => {
    const before = await results().count();
    await press("Compare methods");
    await count(before + 2);
    await page.status(/^Paused at step 1$/);
    await browser.page.setViewportSize({ width: 390, height: 844 });
    const [wide, across] = await browser.page.evaluate(() => {
      const list = document.querySelector("#results .cards");
      return [document.documentElement.scrollWidth, list.scrollWidth > list.clientWidth];
    });
    assert.deepEqual([wide, across], [390, true]);
    await screenshot(browser.page, "compare-phone");
  });

  it("forgets the results with the mesh", async () => {
    await page.dropFile("other.obj", MESH);
    await count(0);
    await panel.getByText("Nothing to compare yet.").waitFor();
    assert.deepEqual(browser.troubles, []);
  });
});
