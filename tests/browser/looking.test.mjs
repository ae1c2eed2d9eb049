// Looking: hover that goes from view to view, pinned values, flights, single pieces, straight and parallel views, clipping, measuring,
// the keys. What shaders do is looked at under both backends, the rest under one.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { RENDERERS, screenshot } from "./chromium.mjs";
import { ellipsoid } from "./meshes.mjs";
import { begin } from "./page.mjs";
import { decodePng, difference } from "./pixels.mjs";

const MESH = ellipsoid(3);
const SURFACE = "Surface view";
const FLAT = "Flattened view";

for (const renderer of RENDERERS) {
  describe(`looking with ${renderer.name}`, { timeout: 600_000 }, () => {
    let browser, page;
    before(async () => {
      ({ browser, page } = await begin(renderer, { name: "ellipsoid.obj", mesh: MESH, pixels: 1 }));
      await page.press("Step");
      await page.status(/^Paused at step 1\b/);
      await browser.page.getByLabel("Texture", { exact: true }).selectOption("none");
    });
    after(() => browser?.close());

    const tip = () => browser.page.locator(".tip");
    /** What the pointer says of a place of a view, given in fractions of its size. */
    async function hover(label, x, y) {
      const box = await page.canvas(label).boundingBox();
      await browser.page.mouse.move(box.x + x * box.width, box.y + y * box.height, { steps: 2 });
      await nextFrames();
      return (await tip().isVisible()) ? tip().textContent() : "";
    }
    const nextFrames = () => page.drawn();
    async function picture(label) {
      await nextFrames();
      return decodePng(await page.canvas(label).screenshot());
    }
    /** Takes pointer and focus out of the views: the ring around a canvas in focus is no part of its picture. */
    async function away() {
      await browser.page.mouse.move(5, 5);
      await browser.page.evaluate(() => document.activeElement.blur());
      await nextFrames();
    }
    async function choose(name) {
      await page.press("View");
      await browser.page.locator("#view-panel").getByRole("button", { name, exact: true }).click();
    }
    /** Whether the menu says that one piece is shown alone. */
    const isAlone = () => browser.page.locator("#view-panel [aria-label='Isolate piece']").evaluate((button) => button.getAttribute("aria-pressed") === "true");
    /** Pixels that two pictures do not share. */
    function changed(one, other) {
      let count = 0;
      for (let i = 0; i < one.rgb.length; i += 3) count += [0, 1, 2].some((c) => Math.abs(one.rgb[i + c] - other.rgb[i + c]) > 24) ? 1 : 0;
      return count;
    }

    it("marks in the other view what is under the pointer", async () => {
      await away();
      const plain = await picture(FLAT);
      assert.match(await hover(SURFACE, 0.5, 0.5), /^Piece \d/);
      const marked = await picture(FLAT);
      // The outline of the piece and the marker; the marker alone moves with the pointer.
      assert.ok(changed(plain, marked) > 40, "nothing is marked");
      await hover(SURFACE, 0.53, 0.47);
      const moved = changed(marked, await picture(FLAT));
      assert.ok(moved > 20 && moved < 800, `${moved} pixels have changed with the marker`);
      await screenshot(browser.page, `${renderer.name}-looking-hover`);
    });

    it("shows both sides of a seam near a cut, and says which pieces it joins and how long it is", async () => {
      await away();
      const [plain, flat] = [await picture(SURFACE), await picture(FLAT)];
      const said = await seam();
      assert.match(said, /^Seam (between pieces \d+ and \d+|of piece \d+ with itself)[\d.\u202f]+\u00a0mm long/);
      assert.ok(changed(flat, await picture(FLAT)) > 150, "the sides are not shown on the charts");
      assert.ok(changed(plain, await picture(SURFACE)) > 60, "the seam is not shown on the surface");
      await screenshot(browser.page, `${renderer.name}-looking-seam`);
    });

    /** Moves over the charts until a seam is said; gives what is. */
    async function seam() {
      const box = await page.canvas(FLAT).boundingBox();
      for (let i = 0; i < 60; i += 1) {
        const said = await hover(FLAT, 0.5, (i * 7) / box.height);
        if (said.startsWith("Seam")) return said;
      }
      throw new Error("there is no seam down the middle of the view");
    }

    it("cuts the surface open by a plane, whose inside is dark, and picks what is behind", async () => {
      await browser.page.keyboard.press("1");
      await away();
      const whole = await picture(SURFACE);
      await choose("Clip");
      const bar = browser.page.getByRole("group", { name: "Clip tools", exact: true });
      await bar.getByRole("slider", { name: "Clip at", exact: true }).fill("500");
      await bar.getByLabel("Clip across", { exact: true }).selectOption("z");
      await away();
      const cut = await picture(SURFACE);
      const middle = 3 * ((cut.height >> 1) * cut.width + (cut.width >> 1));
      const [r, g, b] = cut.rgb.subarray(middle, middle + 3);
      assert.ok(Math.max(r, g, b) - Math.min(r, g, b) < 24 && r < 170, `the inside is ${r} ${g} ${b}: plain and dark`);
      assert.match(await hover(SURFACE, 0.5, 0.5), /^(Piece|Seam)/, "the inside can be pointed at");
      await screenshot(browser.page, `${renderer.name}-looking-clip`);
      await bar.getByRole("slider", { name: "Clip at", exact: true }).fill("0");
      assert.equal(await hover(SURFACE, 0.5, 0.5), "", "where all is cut away there is nothing");
      // From the front the plane across the view is that across z.
      for (const [axis, isLikeZ] of [["x", false], ["y", false], ["view", true]]) {
        await bar.getByLabel("Clip across", { exact: true }).selectOption(axis);
        await bar.getByRole("slider", { name: "Clip at", exact: true }).fill("500");
        await away();
        assert.equal(difference(cut, await picture(SURFACE)) <= 0.5, isLikeZ, `${axis} beside z`);
      }
      await bar.getByRole("button", { name: "End clipping", exact: true }).click();
      assert.equal(await bar.isVisible(), false);
      await away();
      assert.ok(difference(whole, await picture(SURFACE)) < 0.5, "it is whole again");
    });

    it("shows one piece alone and brings all back", async () => {
      await browser.page.keyboard.press("1");
      await away();
      const all = await picture(SURFACE);
      await hover(SURFACE, 0.5, 0.5);
      await browser.page.keyboard.press("i");
      await away();
      await page.until("one piece", isAlone, (is) => is);
      const alone = await picture(SURFACE);
      assert.ok(difference(all, alone) > 1, "all is still shown");
      await screenshot(browser.page, `${renderer.name}-looking-alone`);
      await browser.page.keyboard.press("i");
      await page.until("all pieces", isAlone, (is) => !is);
    });

    it("draws a measured way", async () => {
      await browser.page.keyboard.press("1");
      await away();
      const plain = await picture(SURFACE);
      await choose("Measure");
      const said = browser.page.locator("#measure-tools .say");
      const box = await page.canvas(SURFACE).boundingBox();
      await browser.page.mouse.click(box.x + 0.42 * box.width, box.y + 0.5 * box.height);
      await page.until("one end", () => said.textContent(), (text) => text === "Click the other end");
      await browser.page.mouse.click(box.x + 0.58 * box.width, box.y + 0.5 * box.height);
      const text = await page.until("a length", () => said.textContent(), (text) => text.includes("along"));
      const [, along, straight] = /^([\d.\u202f]+)\u00a0mm along the surface · ([\d.\u202f]+)\u00a0mm straight/.exec(text) ?? [];
      assert.ok(Number(along) >= Number(straight) && Number(straight) > 0, text);
      await away();
      assert.ok(changed(plain, await picture(SURFACE)) > 100, "the way is not drawn");
      assert.equal(await browser.page.locator(".surface .length > span").isVisible(), true);
      await screenshot(browser.page, `${renderer.name}-looking-measure`);
      await browser.page.keyboard.press("Escape");
      assert.equal(await browser.page.getByRole("group", { name: "Measure tools", exact: true }).isVisible(), false);
      // Lengths are placed with the next picture.
      await page.until("no length", () => browser.page.locator(".surface .length > span").isVisible(), (is) => !is);
    });

    if (renderer !== RENDERERS[0]) {
      it("has nothing to complain of in the browser's console", () => assert.deepEqual(browser.troubles, []));
      return;
    }

    it("says the field's value at the pointer, and a click pins it to its point", async () => {
      await browser.page.getByLabel("Surface overlay", { exact: true }).selectOption("u");
      await page.until("the field", () => browser.page.locator(".surface .legend .title").count(), (count) => count === 1);
      const said = await hover(SURFACE, 0.5, 0.45);
      const value = /Scale factor u\s*([−\d.]+)$/.exec(said)?.[1];
      assert.ok(value, said);
      const box = await page.canvas(SURFACE).boundingBox();
      await browser.page.mouse.click(box.x + 0.5 * box.width, box.y + 0.45 * box.height);
      const pins = browser.page.getByRole("button", { name: /^Pinned/ });
      await page.until("pins", () => pins.count(), (count) => count === 2);
      assert.equal(await pins.first().textContent(), value);
      assert.equal(await pins.last().textContent(), value, "the same in the flattened view");
      const before = await pins.first().boundingBox();
      // A drag sets none and takes the pin along.
      await browser.page.mouse.move(box.x + 0.3 * box.width, box.y + 0.4 * box.height);
      await browser.page.mouse.down();
      await browser.page.mouse.move(box.x + 0.36 * box.width, box.y + 0.4 * box.height, { steps: 4 });
      await browser.page.mouse.up();
      await nextFrames();
      const turned = await pins.first().boundingBox();
      assert.ok(turned.x - before.x > 5, `${before.x} and ${turned.x}`);
      await away();
      await screenshot(browser.page, "looking-pins");
      await browser.page.keyboard.press("Escape");
      await page.until("no pins", () => pins.count(), (count) => count === 0);
      await browser.page.mouse.click(box.x + 0.5 * box.width, box.y + 0.45 * box.height);
      await page.until("pins again", () => pins.count(), (count) => count === 2);
      await pins.first().click();
      await page.until("none", () => pins.count(), (count) => count === 0);
      await browser.page.getByLabel("Surface overlay", { exact: true }).selectOption("pieces");
      await page.until("no field", () => browser.page.locator(".surface .legend .title").count(), (count) => count === 0);
    });

    it("flies to a piece on a double click in either view and on Enter in its row, and fits beside all of them", async () => {
      for (const [label, x, y] of [[SURFACE, 0.5, 0.4], [FLAT, 0.3, 0.5]]) {
        await page.press("Fit surface");
        await page.press("Fit pattern");
        await away();
        const [surface, flat] = [await picture(SURFACE), await picture(FLAT)];
        const box = await page.canvas(label).boundingBox();
        await browser.page.mouse.dblclick(box.x + x * box.width, box.y + y * box.height);
        await away();
        assert.ok(difference(surface, await picture(SURFACE)) > 1, `${label}: the surface stays`);
        assert.ok(difference(flat, await picture(FLAT)) > 1, `${label}: the charts stay`);
      }
      await page.press("Fit surface");
      await away();
      const before = await picture(SURFACE);
      const rows = browser.page.locator("#pieces tbody tr");
      await rows.first().focus();
      await browser.page.keyboard.press("ArrowDown");
      assert.equal(await rows.nth(1).evaluate((row) => row === document.activeElement), true);
      await browser.page.keyboard.press("Enter");
      await nextFrames();
      assert.ok(difference(before, await picture(SURFACE)) > 1, "Enter flies nowhere");
      await browser.page.keyboard.press("i");
      await page.until("one piece", isAlone, (is) => is);
      await browser.page.keyboard.press("i");
      const box = await page.canvas(SURFACE).boundingBox();
      await page.press("Fit surface");
      await away();
      const fitted = await picture(SURFACE);
      await browser.page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
      // A wheel is not waited for: the double click could come first.
      await browser.page.evaluate(() => void (window.wheeled = new Promise((done) => addEventListener("wheel", () => done(true), { once: true }))));
      await browser.page.mouse.wheel(0, 300);
      await browser.page.evaluate(() => window.wheeled);
      await nextFrames();
      await browser.page.mouse.dblclick(box.x + 8, box.y + 0.6 * box.height);
      await away();
      assert.ok(difference(fitted, await picture(SURFACE)) < 0.5, "a double click beside everything fits");
    });

    it("looks from six sides by keys and by the menu, with parallel lines of sight where they are wanted", async () => {
      const seen = [];
      for (const keys of ["1", "Shift+Digit1", "3", "Shift+Digit3", "7", "Shift+Digit7"]) {
        await browser.page.keyboard.press(keys);
        await away();
        seen.push(await picture(SURFACE));
      }
      for (const [i, one] of seen.entries()) {
        for (const other of seen.slice(i + 1)) assert.ok(difference(one, other) > 0.3, "two sides look alike");
      }
      await choose("Right");
      await away();
      assert.ok(difference(seen[2], await picture(SURFACE)) < 0.2, "the menu says another right");
      await page.press("View");
      const button = browser.page.locator("#view-panel").getByRole("button", { name: "Orthographic", exact: true });
      await button.click();
      assert.equal(await button.getAttribute("aria-pressed"), "true");
      await browser.page.keyboard.press("Escape");
      await away();
      assert.ok(difference(seen[2], await picture(SURFACE)) > 0.3, "nothing has changed");
      await hover(SURFACE, 0.5, 0.5);
      assert.match(await tip().textContent(), /^(Piece|Seam)/);
      await away();
      await browser.page.keyboard.press("5");
      await away();
      assert.ok(difference(seen[2], await picture(SURFACE)) < 0.2, "and back");
    });

    it("measures with the keyboard, in the unit of the page", async () => {
      await browser.page.keyboard.press("d");
      const said = browser.page.locator("#measure-tools .say");
      await page.canvas(SURFACE).focus();
      await browser.page.keyboard.press("Enter");
      await page.until("one end", () => said.textContent(), (text) => text === "Click the other end");
      await browser.page.keyboard.press("ArrowLeft");
      await browser.page.keyboard.press("ArrowUp");
      await browser.page.keyboard.press("Enter");
      await page.until("a length", () => said.textContent(), (text) => /mm along the surface · .*mm straight/.test(text));
      await page.press("Clear");
      await page.until("no ends", () => said.textContent(), (text) => text.startsWith("Click two places"));
      await page.press("End measuring");
    });

    it("lists its keys", async () => {
      await page.canvas(SURFACE).focus();
      await browser.page.keyboard.press("?");
      const dialog = browser.page.getByRole("dialog", { name: "Keyboard", exact: true });
      await dialog.waitFor({ state: "visible" });
      for (const text of ["Front, right, top", "Measure", "Undo", "Fly to the piece"]) assert.equal(await dialog.getByText(text, { exact: true }).count(), 1, text);
      await screenshot(browser.page, "looking-keys");
      await browser.page.keyboard.press("Escape");
      await dialog.waitFor({ state: "hidden" });
      assert.equal(await page.canvas(SURFACE).evaluate((canvas) => canvas === document.activeElement), true);
      await choose("Keyboard");
      await dialog.waitFor({ state: "visible" });
      await dialog.getByRole("button", { name: "Close Keyboard", exact: true }).click();
    });

    it("keeps menu and bars inside a phone's screen", async () => {
      await browser.page.setViewportSize({ width: 390, height: 844 });
      await nextFrames();
      await choose("Clip");
      await choose("Measure");
      await page.press("View");
      const outside = await browser.page.evaluate(() => {
        const parts = [...document.querySelectorAll("#view-panel, #view-panel button, #clip-tools > *, #measure-tools > *, .surface .tools > *")];
        return parts.filter((node) => node.checkVisibility()).map((node) => [node.id || node.className || node.textContent, node.getBoundingClientRect()])
          .filter(([, box]) => box.width > 0 && (box.left < 0 || box.right > innerWidth)).map(([name]) => name);
      });
      assert.deepEqual(outside, []);
      await screenshot(browser.page, "looking-phone");
      await browser.page.keyboard.press("Escape");
      await page.press("End clipping");
      await page.press("End measuring");
    });

    it("has nothing to complain of in the browser's console", () => assert.deepEqual(browser.troubles, []));
  });
}
