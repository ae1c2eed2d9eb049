// Accessibility: an audit of every state of the page in both themes and two widths, and the page worked by keyboard alone.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, describe, it } from "node:test";

import { RENDERERS } from "./chromium.mjs";
import { ellipsoid } from "./meshes.mjs";
import { begin } from "./page.mjs";

const [renderer] = RENDERERS;
/** The audit is put into the page as text: what the page itself may load is none of its business. */
const AXE = await readFile(new URL("node_modules/axe-core/axe.min.js", import.meta.url), "utf8");
const GRAVE = ["serious", "critical"];
const DESKTOP = { width: 1280, height: 800, themes: ["light", "dark"] };
/** What the phone shows has the colours of the desktop: those of the dark theme are looked at where it shows something of its own. */
const PHONE = { width: 390, height: 844, themes: ["light"] };
const PHONE_DARK = { ...PHONE, themes: ["light", "dark"] };
const METHODS = ["Cones", "Phase field", "Developable patches", "Cut flow"];
const WORKSHOP = "Allowance, notches, sheet …";

/** What is wrong in the page as it stands or within a part of it, one line a finding; nothing where all is well. */
async function audit(page, rules, within) {
  const runOnly = rules ? { type: "rule", values: rules } : null;
  const found = await page.evaluate(async ([runOnly, within]) => {
    // Only the page of today is looked at, so nothing has to be scrolled or loaded for it.
    const options = { resultTypes: ["violations"], iframes: false, preload: false, ...(runOnly ? { runOnly } : {}) };
    return (await window.axe.run(within ?? document, options)).violations;
  }, [runOnly, within]);
  return found
    .filter(({ impact }) => GRAVE.includes(impact))
    .flatMap(({ id, impact, nodes }) => nodes.map(({ target, failureSummary }) => `${impact} ${id} at ${target.join(" ")}: ${failureSummary}`));
}

/**
 * Audits the page in windows and themes: of the dark one the colours, as nothing else differs. Where a state adds a part to a page that was
 * audited before, it is looked for `within` that part only.
 */
async function everywhere(page, state, { within = null, windows = [DESKTOP, PHONE] } = {}) {
  if (within) assert.ok(await page.locator(within).first().isVisible(), `${within} is not shown`);
  const all = [];
  for (const { width, height, themes } of windows) {
    await page.setViewportSize({ width, height });
    for (const colorScheme of themes) {
      await page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
      // Colours are settled by the next frame, as nothing moves.
      await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
      const found = await audit(page, colorScheme === "dark" ? ["color-contrast"] : null, within);
      all.push(...found.map((line) => `${state}, ${width} px, ${colorScheme}: ${line}`));
    }
  }
  await page.setViewportSize({ width: 1280, height: 800 });
  await page.emulateMedia({ colorScheme: "light", reducedMotion: "reduce" });
  assert.deepEqual(all, []);
}

describe("the audit", { timeout: 600_000 }, () => {
  let browser, page, tab;
  before(async () => {
    // The page is audited, not the solvers: 642 vertices keep nobody waiting.
    ({ browser, page, tab } = await begin(renderer, { mesh: ellipsoid(3), script: AXE }));
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

  it("finds nothing in the page at rest", () => everywhere(tab, "at rest", { windows: [DESKTOP, PHONE_DARK] }));

  it("finds nothing after a few steps", async () => {
    for (const step of [1, 2]) {
      await page.press("Step");
      await page.status(new RegExp(`^Paused at step ${step}\\b`));
    }
    await everywhere(tab, "after two steps");
  });

  it("finds nothing in the Export menu and the link", async () => {
    await page.press("Export");
    await everywhere(tab, "Export", { within: "#export-menu" });
    await tab.keyboard.press("Escape");
    await page.press("Share");
    await everywhere(tab, "Share", { within: "#share-pop" });
    await tab.keyboard.press("Escape");
  });

  it("finds nothing with a brush in hand and a field shown", async () => {
    await tab.getByLabel("Surface overlay", { exact: true }).selectOption({ index: 1 });
    await page.press("Brush");
    await everywhere(tab, "brush", { within: ".view" });
    await page.press("Brush");
    await tab.getByLabel("Surface overlay", { exact: true }).selectOption("pieces");
  });

  it("finds nothing in the open Mesh section and all groups of parameters", async () => {
    await page.openMeshSection();
    await tab.evaluate(() => document.querySelectorAll("#parameters details").forEach((details) => (details.open = true)));
    await everywhere(tab, "Mesh section", { within: "#parameters" });
  });

  it("finds nothing in the pattern workshop", async () => {
    await page.press("Export");
    await tab.getByRole("menuitem", { name: WORKSHOP, exact: true }).click();
    const dialog = tab.getByRole("dialog", { name: "Pattern", exact: true });
    await page.until("the sheet is told", () => dialog.locator(".facts").textContent(), (text) => /^\d+ pieces? on/.test(text));
    await tab.evaluate(() => document.querySelectorAll("#pattern details").forEach((details) => (details.open = true)));
    await everywhere(tab, "workshop", { within: "#pattern" });
    await tab.keyboard.press("Escape");
    await dialog.waitFor({ state: "hidden" });
  });

  it("finds nothing while an error is shown", async () => {
    await page.chooseFile("page.obj", "<!doctype html>\n");
    await page.error();
    await everywhere(tab, "error", { within: ".notices" });
    await tab.keyboard.press("Escape");
  });

  for (const method of METHODS) {
    it(`finds nothing in ${method} and its Learn`, async () => {
      await tab.getByRole("tab", { name: method, exact: true }).click();
      await page.until("the method is shown", () => tab.getByRole("tab", { name: method, exact: true }).getAttribute("aria-selected"), (on) => on === "true");
      await page.status(/^(Ready|Paused|Converged)/);
      await everywhere(tab, method, { windows: [DESKTOP, PHONE_DARK] });
      await page.press("Learn");
      // All lessons are set alike: one of them is enough for the phone.
      await everywhere(tab, `Learn of ${method}`, { within: "#learn-panel", windows: method === "Cut flow" ? [DESKTOP, PHONE_DARK] : [DESKTOP] });
      await tab.keyboard.press("Escape");
    });
  }
});

/** What has the focus: a name, whether it is in sight, and how its mark stands out from what is behind it. */
function focused() {
  const node = document.activeElement;
  if (node === document.body) return null;
  // A hidden file input shows its focus on its label.
  const marked = node.matches(".sr") ? node.closest("label") : node;
  const box = marked.getBoundingClientRect();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const top = document.elementFromPoint(Math.min(Math.max(x, 0), innerWidth - 1), Math.min(Math.max(y, 0), innerHeight - 1));
  const isInSight = box.width > 0 && box.height > 0 && box.right > 0 && box.bottom > 0 && box.x < innerWidth && box.y < innerHeight;
  const isCovered = !(top && (marked.contains(top) || top.contains(marked) || top.closest("label, .stage") === marked.closest("label, .stage")));
  const context = Object.assign(document.createElement("canvas"), { width: 1, height: 1 }).getContext("2d", { willReadFrequently: true });
  const light = (colour, under = [0, 0, 0]) => {
    context.fillStyle = `rgb(${under})`;
    context.fillRect(0, 0, 1, 1);
    context.fillStyle = colour;
    context.fillRect(0, 0, 1, 1);
    return [...context.getImageData(0, 0, 1, 1).data].slice(0, 3);
  };
  const luminance = (rgb) => rgb.map((c) => c / 255).map((c) => (c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)).reduce((sum, c, i) => sum + [0.2126, 0.7152, 0.0722][i] * c, 0);
  let under = null;
  for (let at = marked.parentElement; at; at = at.parentElement) {
    const colour = getComputedStyle(at).backgroundColor;
    if (colour !== "rgba(0, 0, 0, 0)") {
      under = light(colour);
      break;
    }
  }
  const style = getComputedStyle(marked);
  const line = getComputedStyle(marked, "::after");
  const mark = marked.role === "separator" ? line.backgroundColor : style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2 ? style.outlineColor : null;
  let contrast = 0;
  if (mark && under) {
    const [a, b] = [luminance(light(mark, under)), luminance(under)];
    contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  }
  const name = node.getAttribute("aria-label") || node.labels?.[0]?.textContent || node.textContent.trim().slice(0, 30) || node.id || node.tagName;
  window.visited ??= new Set();
  const isNew = !window.visited.has(node);
  window.visited.add(node);
  return { name: `${node.tagName.toLowerCase()} “${name.trim()}”`, isInSight, isCovered, contrast, isNew };
}

/** What can be reached by Tab and was not. */
function missed() {
  const candidates = document.querySelectorAll("a[href], button, select, input, summary, canvas[tabindex], [tabindex]");
  const isRadio = (node) => node.type === "radio" && !node.checked;
  return [...candidates]
    .filter((node) => node.tabIndex >= 0 && !node.disabled && !isRadio(node) && node.checkVisibility({ visibilityProperty: true }) && !node.closest("dialog"))
    .filter((node) => !window.visited.has(node))
    .map((node) => `${node.tagName.toLowerCase()} ${node.id || node.getAttribute("aria-label") || node.textContent.trim().slice(0, 30)}`);
}

describe("the keyboard alone", { timeout: 600_000 }, () => {
  let browser, page, tab;
  before(async () => {
    ({ browser, page, tab } = await begin(renderer, { query: "sample=ball&run=0" }));
    await page.until("the surface is described", () => tab.locator("#surface-words").textContent(), (text) => text !== "");
  });
  after(() => browser?.close());

  const focus = () => tab.evaluate(focused);
  const focusName = () => tab.evaluate(() => document.activeElement.getAttribute("aria-label"));

  /** Walks through the page with Tab until it leaves it; gives what was wrong on the way, and how many stops there were. */
  async function walk(key = "Tab", most = 150) {
    await tab.evaluate(() => {
      window.visited = new Set();
      document.activeElement.blur();
      getSelection().removeAllRanges();
      scrollTo(0, 0);
    });
    const wrong = [];
    let stops = 0;
    for (; stops < most; stops += 1) {
      await tab.keyboard.press(key);
      const now = await focus();
      // Past the end the browser's own controls have it.
      if (now === null || !now.isNew) break;
      if (!now.isInSight) wrong.push(`${now.name} is out of sight`);
      else if (now.isCovered) wrong.push(`${now.name} is covered`);
      if (!(now.contrast >= 3)) wrong.push(`the focus on ${now.name} stands out by ${now.contrast.toFixed(2)} only`);
    }
    const left = await tab.evaluate(missed);
    return { wrong: [...wrong, ...left.map((name) => `${name} cannot be reached`)], stops };
  }

  for (const colorScheme of ["light", "dark"]) {
    it(`reaches everything, and shows where it is, ${colorScheme}`, async (t) => {
      await tab.emulateMedia({ colorScheme, reducedMotion: "reduce" });
      const { wrong, stops } = await walk();
      t.diagnostic(`${stops} stops`);
      assert.deepEqual(wrong, []);
      assert.ok(stops > 30, `only ${stops} stops`);
    });
  }

  it("reaches everything on a phone", async () => {
    await tab.setViewportSize({ width: 390, height: 844 });
    assert.deepEqual((await walk()).wrong, []);
    await tab.setViewportSize({ width: 1280, height: 800 });
  });

  it("works a menu, and comes back from it", async () => {
    await tab.getByRole("button", { name: "Export", exact: true }).focus();
    await tab.keyboard.press("ArrowDown");
    const item = () => tab.evaluate(() => document.activeElement.textContent);
    assert.equal(await item(), "Mesh (OBJ)");
    await tab.keyboard.press("ArrowDown");
    assert.equal(await item(), "UV mesh (OBJ)");
    await tab.keyboard.press("End");
    assert.equal(await item(), "All files (ZIP)");
    await tab.keyboard.press("Escape");
    assert.equal(await focusName(), "Export");
    assert.ok(!(await tab.getByRole("menu", { name: "Export" }).isVisible()));
  });

  it("keeps the focus in the workshop, and gives it back", async () => {
    await tab.keyboard.press("ArrowDown");
    await tab.getByRole("menuitem", { name: WORKSHOP, exact: true }).focus();
    await tab.keyboard.press("Enter");
    await tab.getByRole("dialog", { name: "Pattern", exact: true }).waitFor();
    for (let i = 0; i < 60; i += 1) {
      await tab.keyboard.press("Tab");
      const where = await tab.evaluate(() => (document.activeElement === document.body ? "dialog" : (document.activeElement.closest("dialog")?.id ?? document.activeElement.outerHTML.slice(0, 80))));
      assert.ok(where === "dialog" || where === "pattern", `the focus went to ${where}`);
    }
    await tab.keyboard.press("Escape");
    await page.until("the focus is back", focusName, (name) => name === "Export");
  });

  it("opens Learn, walks through it and comes back", async () => {
    await tab.getByRole("button", { name: "Learn", exact: true }).focus();
    await tab.keyboard.press("Enter");
    await page.until("its title has the focus", () => tab.evaluate(() => document.activeElement.id), (id) => id === "learn-title");
    for (let i = 0; i < 12; i += 1) {
      await tab.keyboard.press("Tab");
      const now = await focus();
      assert.ok(now?.isInSight, `${now?.name} is out of sight`);
    }
    await tab.keyboard.press("Escape");
    await page.until("the focus is back", focusName, (name) => name === "Learn");
  });

  it("says what the views show, and turns them", async () => {
    for (const [label, words] of [["Surface view", /^Ball in 2 pieces: piece 1 has 50\.0\s%.*Arrow keys turn it/], ["Flattened view", /^2 flat pieces, .* together, no flipped triangles\. Arrow keys move it/]]) {
      const canvas = page.canvas(label);
      const text = await canvas.evaluate((node) => document.getElementById(node.getAttribute("aria-describedby")).textContent);
      assert.match(text, words);
      await canvas.focus();
      const before = await canvas.screenshot();
      await tab.keyboard.press("ArrowLeft");
      await page.until("the picture is another", () => canvas.screenshot(), (picture) => !picture.equals(before));
    }
    for (const name of ["Measures", "Pieces"]) await tab.getByRole("table", { name, exact: true }).waitFor();
  });

  it("moves the lines between the panes, and finds them there again", async () => {
    const line = (name) => tab.getByRole("separator", { name, exact: true });
    const value = async (name) => Number(await line(name).getAttribute("aria-valuenow"));
    const NAMES = { "Width of the parameters": "ArrowRight", "Width of the surface view": "ArrowRight", "Height of the plots and tables": "ArrowUp" };
    const panes = () => Promise.all(["#parameters", ".view.surface", ".view.flat", ".dock"].map((pane) => tab.locator(pane).boundingBox()));
    const moved = {};
    for (const [name, key] of Object.entries(NAMES)) {
      const before = await value(name);
      await line(name).focus();
      await tab.keyboard.press(`Shift+${key}`);
      moved[name] = await value(name);
      assert.ok(moved[name] > before, `${name} stays at ${before}`);
    }
    await tab.reload();
    await page.status(/^(Ready|Running|Paused|Converged)/);
    for (const name of Object.keys(NAMES)) assert.equal(await value(name), moved[name], name);
    for (const key of ["Home", "End"]) {
      for (const name of Object.keys(NAMES)) {
        await line(name).focus();
        await tab.keyboard.press(key);
      }
      for (const { width, height } of await panes()) assert.ok(width >= 239 && height >= 131, `a pane of ${width} × ${height} at ${key}`);
    }
    const box = await line("Width of the parameters").boundingBox();
    const { width } = (await panes())[0];
    await tab.mouse.move(box.x + box.width / 2, box.y + 60);
    await tab.mouse.down();
    await tab.mouse.move(box.x + box.width / 2 - 100, box.y + 60, { steps: 3 });
    await tab.mouse.up();
    assert.ok(Math.abs((await panes())[0].width - (width - 100)) <= 2, "the line follows the pointer");
    for (const name of Object.keys(NAMES)) {
      await line(name).focus();
      await tab.keyboard.press("Enter");
    }
    assert.equal(await value("Width of the parameters"), 280);
    assert.equal(await tab.evaluate(() => localStorage.getItem("cutflow.layout")), null);
    await tab.setViewportSize({ width: 390, height: 844 });
    assert.equal(await tab.getByRole("separator").filter({ visible: true }).count(), 0);
  });
});
