// What the canvases and the sheet show, against pictures that are kept in tests/golden/pictures: a fixed set of states, each after
// the same steps from the same camera. `CUTFLOW_NEW_PICTURES=1 cargo xtask test --browser` writes them anew; look at each before it
// is committed. What differs from the kept one is left among the screenshots.

import assert from "node:assert/strict";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, describe, it } from "node:test";

import { PAGE, PATIENCE_MS, RENDERERS, open } from "./chromium.mjs";
import { Page } from "./page.mjs";
import { decodePng, difference } from "./pixels.mjs";

const KEPT = join(import.meta.dirname, "../golden/pictures");
const IS_RENEWING = process.env.CUTFLOW_NEW_PICTURES === "1";
/** Views of about 280 × 210 pixels: small files, and large enough for what a person would notice. */
const WINDOW = { width: 840, height: 600 };

/**
 * What may differ. Of 255, the mean; and the share of the pixels of which a channel is off by more than `OFF`: rims are smoothed
 * differently by other graphics, a line that is gone or a colour that has changed is more than that.
 */
const OFF = 32;
const ALLOWED = { mean: 1, share: 0.01 };
/** Words on the sheet are set in the machine's own fonts. */
const ALLOWED_WITH_WORDS = { mean: 4, share: 0.03 };

/** `{ mean, share }` of two pictures of one size. */
function compare(one, other) {
  let off = 0;
  for (let i = 0; i < one.rgb.length; i += 3) {
    if ([0, 1, 2].some((k) => Math.abs(one.rgb[i + k] - other.rgb[i + k]) > OFF)) off += 1;
  }
  return { mean: difference(one, other), share: off / (one.rgb.length / 3) };
}

const isAlike = (found, allowed) => found.mean <= allowed.mean && found.share <= allowed.share;
const file = (name) => join(KEPT, `${name}.png`);
const kept = (name) => decodePng(readFileSync(file(name)));

for (const renderer of RENDERERS) {
  describe(`pictures with ${renderer.name}`, { timeout: 600_000 }, () => {
    let browser, page, tab;
    before(async () => {
      browser = await open(renderer);
      tab = browser.page;
      page = new Page(tab);
      await tab.setViewportSize(WINDOW);
    });
    after(() => browser?.close());

    async function visit(query) {
      await page.visit(`${PAGE}?renderer=${renderer.query}&run=0&${query}`);
      await tab.waitForSelector("html[data-renderer]", { state: "attached" });
      assert.equal(await tab.locator("html").getAttribute("data-renderer"), renderer.name);
      // What is written over the views is set in the machine's own fonts.
      await tab.evaluate(() => document.querySelectorAll(".numbers, .cone-labels, .legend, .alarm, .hint").forEach((layer) => (layer.style.visibility = "hidden")));
      await tab.mouse.move(2, 2);
    }

    async function steps(count) {
      for (let step = 1; step <= count; step += 1) {
        await page.pressAtOnce("Step");
        await page.status(new RegExp(`^(Paused at step ${step}|Converged after \\d+ steps?)\\b`));
      }
    }

    /** A picture that has come to rest. */
    async function still(target) {
      let last = await target.screenshot();
      return page.until("the picture comes to rest", async () => {
        await tab.waitForTimeout(250);
        const next = await target.screenshot();
        const isSame = next.equals(last);
        last = next;
        return isSame ? next : null;
      }, (picture) => picture !== null);
    }

    /** Compares what `target` shows with the picture kept under a name, or keeps it. */
    async function check(t, name, target, allowed = ALLOWED) {
      if (IS_RENEWING && renderer === RENDERERS[0]) {
        mkdirSync(KEPT, { recursive: true });
        writeFileSync(file(name), await still(target));
        return;
      }
      const wanted = kept(name);
      const end = Date.now() + PATIENCE_MS / 3;
      let picture, found;
      do {
        // The newest scene may take some frames to reach the canvas.
        picture = await still(target);
        const now = decodePng(picture);
        assert.deepEqual([now.width, now.height], [wanted.width, wanted.height], `${name} has another size than the kept picture`);
        found = compare(now, wanted);
      } while (!isAlike(found, allowed) && Date.now() < end);
      t.diagnostic(`${name}: mean ${found.mean.toFixed(2)}, ${(100 * found.share).toFixed(2)} % of the pixels`);
      if (isAlike(found, allowed)) return;
      const path = join(process.env.CUTFLOW_SCREENSHOTS, `${renderer.name}-${name}-differs.png`);
      writeFileSync(path, picture);
      assert.fail(`${name} is off by ${found.mean.toFixed(2)} of 255 in the mean (${allowed.mean} allowed) and ${(100 * found.share).toFixed(2)} % of its pixels differ (${100 * allowed.share} % allowed): see ${path}, renew with CUTFLOW_NEW_PICTURES=1`);
    }

    const surface = () => page.canvas("Surface view");
    const flat = () => page.canvas("Flattened view");

    it("draws the ball after fourteen steps, light and dark", async (t) => {
      // Triangles of a coarser sphere are alike but for rounding: which ones its first steps are made on is no matter of pictures.
      await visit("sample=ball&p.coarse=false");
      await steps(14);
      await check(t, "ball-surface", surface());
      await check(t, "ball-flat", flat());
      await tab.emulateMedia({ colorScheme: "dark" });
      await check(t, "ball-surface-dark", surface());
      await tab.emulateMedia({ colorScheme: "light" });
    });

    it("draws a field", async (t) => {
      await tab.getByLabel("Surface overlay", { exact: true }).selectOption("u");
      await page.until("its legend is shown", () => tab.locator(".surface .scale").count(), (count) => count === 1);
      await check(t, "field-surface", surface());
      await check(t, "field-flat", flat());
    });

    it("draws cones", async (t) => {
      await visit("sample=sinusoidal_sheet&method=cones");
      await page.status(/^(Converged|Ready|Paused)/);
      await page.until("there are cones", () => tab.getByRole("table", { name: "Cones" }).locator("tbody tr").count(), (count) => count > 0);
      await check(t, "cones-surface", surface());
      await check(t, "cones-flat", flat());
    });

    // The sheet is an image of its own, which the graphics of the views have no part in.
    if (renderer === RENDERERS[0]) {
      it("shows the sheet of the workshop", async (t) => {
        await visit("sample=ball");
        await page.press("Export");
        await tab.getByRole("menuitem", { name: "Allowance, notches, sheet …", exact: true }).click();
        const dialog = tab.getByRole("dialog", { name: "Pattern", exact: true });
        await dialog.getByRole("button", { name: "Plush", exact: true }).click();
        await page.until("the sheet is told", () => dialog.locator(".facts").textContent(), (text) => /^\d+ pieces? on/.test(text));
        await page.until("Plush is chosen", () => dialog.getByRole("button", { name: "Plush", exact: true }).getAttribute("aria-pressed"), (on) => on === "true");
        await check(t, "sheet", dialog.locator(".board img"), ALLOWED_WITH_WORDS);
      });
    }
  });
}

describe("the comparison", () => {
  it("tells the kept pictures from each other", () => {
    for (const [one, other] of [["ball-surface", "ball-surface-dark"], ["cones-surface", "field-surface"], ["cones-flat", "field-flat"]]) {
      const found = compare(kept(one), kept(other));
      assert.ok(!isAlike(found, ALLOWED), `${one} and ${other} pass for the same: ${JSON.stringify(found)}`);
    }
  });

  it("sees a cut that is gone", () => {
    // Dark lines of two pixels are little of a picture: painted over in the colour beside them they must be missed.
    const whole = kept("ball-surface");
    const without = { ...whole, rgb: Uint8Array.from(whole.rgb) };
    for (let y = 0; y < whole.height; y += 1) {
      for (let x = 6; x < whole.width; x += 1) {
        const at = 3 * (y * whole.width + x);
        if (Math.max(...whole.rgb.subarray(at, at + 3)) < 90) without.rgb.copyWithin(at, at - 18, at - 15);
      }
    }
    assert.ok(!isAlike(compare(without, whole), ALLOWED), JSON.stringify(compare(without, whole)));
  });
});
