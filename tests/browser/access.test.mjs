// Accessibility: an audit of every state of the page in both themes and two widths, and the page worked by keyboard alone.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, describe, it } from "node:test";

import { PAGE, RENDERERS, open } from "./chromium.mjs";
import { Page } from "./page.mjs";

const [renderer] = RENDERERS;
/** The audit is put into the page as text: what the page itself may load is none of its business. */
const AXE = await readFile(new URL("node_modules/axe-core/axe.min.js", import.meta.url), "utf8");
const GRAVE = ["serious", "critical"];
const WIDTHS = [[1280, 800], [390, 844]];
const METHODS = ["Cones", "Phase field", "Developable patches", "Cut flow"];
const WORKSHOP = "Allowance, notches, sheet …";

/** What is wrong in the page as it stands, one line a finding; nothing where all is well. */
async function audit(page, grave = GRAVE) {
  const found = await page.evaluate(async () => (await window.axe.run(document, { resultTypes: ["violations"] })).violations);
  return found
    .filter(({ impact }) => grave.includes(impact))
    .flatMap(({ id, impact, nodes }) => nodes.map(({ target, failureSummary }) => `${impact} ${id} at ${target.join(" ")}: ${failureSummary}`));
}

/** Audits the page in both themes and at both widths. */
async function everywhere(page, state) {
  const all = [];
  for (const [width, height] of WIDTHS) {
    await page.setViewportSize({ width, height });
    for (const colorScheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
      // Colours are settled by the next frame, as nothing moves.
      await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
      all.push(...(await audit(page)).map((line) => `${state}, ${width} px, ${colorScheme}: ${line}`));
    }
  }
  await page.setViewportSize({ width: 1280, height: 800 });
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
  assert.deepEqual(all, []);
}

describe("the audit", { timeout: 600_000 }, () => {
  let browser, page, tab;
  before(async () => {
    browser = await open(renderer);
    tab = browser.page;
    page = new Page(tab);
    await tab.addInitScript(AXE);
    await page.visit(`${PAGE}?renderer=${renderer.query}&sample=ball&run=0`);
    await page.status(/^Ready/);
  });
  after(() => browser?.close());

  it("sees what is wrong where something is", async () => {
    await tab.evaluate(() => {
      document.querySelector("#orbit").removeAttribute("aria-label");
      document.querySelector("#orbit").removeAttribute("title");
    });
    assert.match((await audit(tab)).join("\n"), /button-name at #orbit/);
    await tab.evaluate(() => document.querySelector("#orbit").setAttribute("aria-label", "Orbit"));
  });

  it("finds nothing in the page at rest", () => everywhere(tab, "at rest"));

  it("finds nothing after a few steps", async () => {
    for (const step of [1, 2]) {
      await page.press("Step");
      await page.status(new RegExp(`^Paused at step ${step}\\b`));
    }
    await everywhere(tab, "after two steps");
  });

  it("finds nothing in the Export menu and the link", async () => {
    await page.press("Export");
    await everywhere(tab, "Export");
    await tab.keyboard.press("Escape");
    await page.press("Share");
    await everywhere(tab, "Share");
    await tab.keyboard.press("Escape");
  });

  it("finds nothing with a brush in hand and a field shown", async () => {
    await tab.getByLabel("Surface overlay", { exact: true }).selectOption({ index: 1 });
    await page.press("Brush");
    await everywhere(tab, "brush");
    await page.press("Brush");
    await tab.getByLabel("Surface overlay", { exact: true }).selectOption("pieces");
  });

  it("finds nothing in the open Mesh section and all groups of parameters", async () => {
    await page.openMeshSection();
    await tab.evaluate(() => document.querySelectorAll("#parameters details").forEach((details) => (details.open = true)));
    await everywhere(tab, "Mesh section");
  });

  it("finds nothing in the pattern workshop", async () => {
    await page.press("Export");
    await tab.getByRole("menuitem", { name: WORKSHOP, exact: true }).click();
    const dialog = tab.getByRole("dialog", { name: "Pattern", exact: true });
    await page.until("the sheet is told", () => dialog.locator(".facts").textContent(), (text) => /^\d+ pieces? on/.test(text));
    await tab.evaluate(() => document.querySelectorAll("#pattern details").forEach((details) => (details.open = true)));
    await everywhere(tab, "workshop");
    await tab.keyboard.press("Escape");
  });

  it("finds nothing while an error is shown", async () => {
    await page.chooseFile("page.obj", "<!doctype html>\n");
    await page.error();
    await everywhere(tab, "error");
    await tab.keyboard.press("Escape");
  });

  for (const method of METHODS) {
    it(`finds nothing in ${method} and its Learn`, async () => {
      await tab.getByRole("tab", { name: method, exact: true }).click();
      await page.until("the method is shown", () => tab.getByRole("tab", { name: method, exact: true }).getAttribute("aria-selected"), (on) => on === "true");
      await page.status(/^(Ready|Paused|Converged)/);
      await everywhere(tab, method);
      await page.press("Learn");
      await everywhere(tab, `Learn of ${method}`);
      await tab.keyboard.press("Escape");
    });
  }
});
