// Patterns as a person meets them: choose a trade, look at the sheet, change what is asked, take the files away; save everything
// and open it again. The engine is the same under either backend.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, describe, it } from "node:test";

import { COARSE, PAGE, RENDERERS, open, screenshot } from "./chromium.mjs";
import { Page } from "./page.mjs";

const [renderer] = RENDERERS;
const ITEM = "Allowance, notches, sheet …";

describe("patterns", { timeout: 600_000 }, () => {
  let browser, page, dialog;
  before(async () => {
    browser = await open(renderer, COARSE);
    page = new Page(browser.page);
    await page.visit(`${PAGE}?renderer=${renderer.query}&sample=ball&run=0`);
    await page.status(/^Ready/);
    dialog = browser.page.getByRole("dialog", { name: "Pattern", exact: true });
  });
  after(() => browser?.close());

  const openWorkshop = async () => {
    await page.press("Export");
    await browser.page.getByRole("menuitem", { name: ITEM, exact: true }).click();
    await dialog.waitFor({ state: "visible" });
  };
  const facts = () => dialog.locator(".facts").textContent();
  const download = async (name) => {
    const [file] = await Promise.all([browser.page.waitForEvent("download"), dialog.getByRole("button", { name, exact: true }).click()]);
    return readFile(await file.path());
  };

  it("shows the sheet, and fills the view with it", async () => {
    await openWorkshop();
    await page.until("the sheet is told", facts, (text) => /^2 pieces on \d+ × \d+.mm.* used, \d+ page/.test(text));
    const image = dialog.locator(".board img");
    await page.until("the picture is there", () => image.evaluate(({ naturalWidth }) => naturalWidth), (width) => width > 0);
    const [board, paper] = await Promise.all([".board", ".paper"].map((name) => dialog.locator(name).boundingBox()));
    assert.ok(board.height > 0.5 * paper.height || board.width > 0.5 * paper.width);
    assert.ok(board.height <= paper.height && board.width <= paper.width);
  });

  it("does what a trade asks, and says which it is", async () => {
    await dialog.getByRole("button", { name: "Plush", exact: true }).click();
    await page.until("Plush is chosen", () => dialog.getByRole("button", { name: "Plush", exact: true }).getAttribute("aria-pressed"), (on) => on === "true");
    assert.equal(await dialog.getByLabel("Seam allowance", { exact: true }).first().inputValue(), "6.0");
    await screenshot(browser.page, "pattern");
    await browser.page.emulateMedia({ colorScheme: "dark" });
    await screenshot(browser.page, "pattern-dark");
    await browser.page.emulateMedia({ colorScheme: "light" });
  });

  it("writes what it shows, in every format", async () => {
    const svg = (await download("SVG")).toString("utf8");
    assert.match(svg, /inkscape:label="SEW"/);
    assert.match((await download("DXF")).toString("latin1"), /AC1009/);
    assert.match((await download("PDF")).toString("latin1").slice(0, 8), /^%PDF-1\./);
    assert.equal((await download("All files")).toString("latin1").slice(0, 2), "PK");
  });

  it("gives a seam an allowance of its own", async () => {
    await dialog.getByText("Seams", { exact: true }).last().click();
    const input = dialog.getByLabel("Allowance of seam 1", { exact: true });
    await input.fill("12");
    await input.press("Enter");
    await page.until("the allowance", () => input.inputValue(), (value) => value === "12.0");
    assert.match((await download("SVG")).toString("utf8"), /data-piece="A"/);
  });

  it("says in the same place what cannot be had", async () => {
    const input = dialog.getByLabel("Allowance of seam 1", { exact: true });
    await input.fill("1000");
    await input.press("Enter");
    await page.until("a notice", () => dialog.getByRole("list", { name: "Notices" }).textContent(), (text) => /out of range/i.test(text));
  });

  it("fits a phone", async () => {
    await browser.page.setViewportSize({ width: 390, height: 844 });
    const wide = await dialog.evaluate(({ scrollWidth, clientWidth }) => scrollWidth - clientWidth);
    assert.ok(wide <= 0, `${wide} px too wide`);
    await screenshot(browser.page, "pattern-phone");
    await browser.page.setViewportSize({ width: 1280, height: 800 });
  });

  it("closes with Escape and leaves the page as it was", async () => {
    await browser.page.keyboard.press("Escape");
    await dialog.waitFor({ state: "hidden" });
    assert.equal(await browser.page.getByLabel("Width (x)", { exact: true }).count(), 1);
  });

  it("saves a project that comes back as it was", async () => {
    await page.press("Step");
    await page.status(/^Paused at step 1/);
    const before = await page.export("Pattern (SVG)");
    const project = await page.exportBytes("Project (JSON)");
    await page.press("Reset");
    await page.status(/^Ready/);
    await page.dropFile("saved-project.json", project);
    await page.status(/^Paused at step 1/);
    assert.equal(await page.export("Pattern (SVG)"), before);
  });
});
