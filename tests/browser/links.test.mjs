// Links bring a setting back, and small frames in other pages show it.

import assert from "node:assert/strict";
import { after, describe, it } from "node:test";

import { PAGE, screenshot } from "./chromium.mjs";
import { ellipsoid } from "./meshes.mjs";
import { records, visitors } from "./visitors.mjs";

const address = (query) => `${PAGE}?renderer=webgl&${query}`;

describe("addresses", { timeout: 600_000 }, () => {
  const { visitor, tab, leave } = visitors();

  describe("links", () => {
    after(leave);

    for (const method of ["cutflow", "cones", "phasefield", "developable"]) {
      it(`bring a setting of ${method} back, without another method before`, async () => {
        const context = await visitor();
        const page = await tab(context);
        await page.visit(address(`sample=ball&method=${method}&run=0`));
        const canvas = page.canvas("Surface view");
        await canvas.focus();
        for (let i = 0; i < 5; i += 1) await page.page.keyboard.press("ArrowRight");
        await page.page.keyboard.press("+");
        await page.page.getByLabel("Texture", { exact: true }).selectOption("circles");
        const slider = (of) => of.page.locator("#settings input[type=range]:visible").first();
        const before = await slider(page).inputValue();
        await slider(page).press("ArrowRight");
        const value = await page.until("another value", () => slider(page).inputValue(), (text) => text !== before);
        const link = await page.until(
          "the link says so",
          async () => {
            await page.press("Share");
            const text = await page.page.getByLabel("Link to this setting").inputValue();
            await page.page.keyboard.press("Escape");
            return text;
          },
          (text) => /p\./.test(text),
        );
        await page.page.close();

        const next = await tab(context);
        await next.page.addInitScript(() => {
          window.seen = new Set();
          addEventListener("DOMContentLoaded", () =>
            new MutationObserver(() => document.documentElement.dataset.method && seen.add(document.documentElement.dataset.method)).observe(document.documentElement, { attributes: true }),
          );
        });
        await next.visit(`${link}&renderer=webgl&run=0`);
        await next.until("the parameter is back", () => slider(next).inputValue(), (text) => text === value);
        assert.equal(await next.page.getByRole("tab", { selected: true }).first().getAttribute("id"), `tab-${method}`);
        assert.deepEqual((await next.page.evaluate(() => [...seen])).filter((name) => name !== method), []);
        assert.equal(await next.page.getByLabel("Texture", { exact: true }).inputValue(), "circles");
        await next.page.waitForSelector("html[data-renderer]", { state: "attached" });
        const same = await next.until(
          "the same link comes out again",
          async () => {
            await next.press("Share");
            const text = await next.page.getByLabel("Link to this setting").inputValue();
            await next.page.keyboard.press("Escape");
            return text;
          },
          (text) => text === link,
        );
        assert.match(same, /view=[-\d.,]+/);
        assert.deepEqual(next.troubles, []);
      });
    }

    it("without a sample give their setting to the first mesh that is opened, and to no other", async () => {
      for (const query of ["sample=none&", ""]) {
        const page = await tab(await visitor());
        await page.visit(address(`${query}method=cones&run=0&p.lambda=0.02&p.round=false`));
        const lambda = () => page.page.locator("#settings .path + .param input:not([type=range])").inputValue();
        await page.bring("first.obj", ellipsoid(2), /^(Ready$|Converged)/);
        await page.until("the link's λ", lambda, (text) => text === "0.0200");
        await page.until("the link's switch", () => page.page.getByRole("switch", { name: "Merge clusters", exact: true }).isChecked(), (value) => !value);
        await page.bring("second.obj", ellipsoid(2), /^(Ready$|Converged)/);
        await page.until("the usual λ", lambda, (text) => text !== "0.0200");
        assert.deepEqual(page.troubles, []);
      }
    });

    it("that would be too long are refused with a word", async () => {
      const page = await tab(await visitor());
      await page.visit(`${address("run=0")}#${"x".repeat(10)}`);
      // A path of its own is the only thing here that can be long.
      await page.page.evaluate(() => history.replaceState(null, "", `/${"a".repeat(9000)}/index.html`));
      await page.press("Share");
      await page.page.getByText("Too much for a link").waitFor();
      assert.equal(await page.page.getByLabel("Link to this setting").isVisible(), false);
    });
  });

  describe("frames", () => {
    after(leave);

    it("of 480 by 360 hold both views, the run and the methods", async () => {
      const page = await tab(await visitor({ viewport: { width: 480, height: 360 } }));
      await page.visit(address("embed=1&run=0"));
      for (const name of ["Run", "Pause", "Step", "Reset"]) {
        const box = await page.page.getByRole("button", { name, exact: true }).boundingBox();
        assert.ok(box && box.x >= 0 && box.x + box.width <= 480 && box.y + box.height <= 360, `${name} is in the frame`);
      }
      for (const name of ["Surface view", "Flattened view"]) {
        const { width, height } = await page.canvas(name).boundingBox();
        assert.ok(width > 150 && height > 120, `${name} is ${width} by ${height}`);
      }
      assert.equal(await page.page.getByRole("button", { name: "Export", exact: true }).isVisible(), false);
      const { scrollWidth, scrollHeight } = await page.page.evaluate(() => document.documentElement);
      const sizes = await page.page.evaluate(() => [document.documentElement.scrollWidth, document.documentElement.scrollHeight]);
      assert.deepEqual(sizes, [480, 360], `nothing scrolls ${scrollWidth} ${scrollHeight}`);
      await page.press("Step");
      await page.status(/^Paused at step 1$/);
      const link = page.page.getByRole("link", { name: "Open in Cutflow" });
      await link.focus();
      const href = await link.getAttribute("href");
      assert.match(href, /sample=ball/);
      assert.doesNotMatch(href, /embed/);
      await screenshot(page.page, "embed");
      await page.page.waitForTimeout(1500);
      assert.deepEqual(await records(page), [], "a guest keeps nothing");
      assert.deepEqual(page.troubles, []);
    });

    it("open Learn at a stage", async () => {
      const page = await tab(await visitor());
      await page.page.goto(address("learn=1&stage=3&run=0"));
      await page.page.getByText(/^Stage 3 of \d+$/).waitFor();
    });
  });
});
