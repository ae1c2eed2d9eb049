// What a person steers the cut with: presets, single parameters, the brush, symmetries, hidden seams, the fold preview.
// Under one backend: what is drawn is compared in page.test.mjs.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { RENDERERS, screenshot } from "./chromium.mjs";
import { asObj, ellipsoid, parseObj } from "./meshes.mjs";
import { begin } from "./page.mjs";
import { decodePng, difference } from "./pixels.mjs";

/** 642 vertices: three mirror planes, and quick to cut. */
const MESH = parseObj(ellipsoid(3));
/** The same with no plane or axis left, not even by the few per cent that count as symmetric. */
const CROOKED = {
  ...MESH,
  vertices: MESH.vertices.map(([x, y, z]) => [x + 0.25 * x * x + 0.3 * y * z, 0.7 * y + 0.3 * x * y + 0.25 * z * z, 0.5 * z + 0.35 * x * y + 0.2 * y * y * x]),
};
const [renderer] = RENDERERS;

/** Runs in the page: keeps what the page tells the engine. */
function recordCommands() {
  window.sent = [];
  const post = Worker.prototype.postMessage;
  Worker.prototype.postMessage = function (message, ...rest) {
    if (message.type === "command") window.sent.push(message.command);
    return post.call(this, message, ...rest);
  };
}

describe("steering the cut", { timeout: 600_000 }, () => {
  let browser, page;
  before(async () => {
    ({ browser, page } = await begin(renderer, { script: recordCommands, name: "ellipsoid.obj", mesh: asObj(MESH) }));
  });
  after(() => browser?.close());

  const button = (name, within = browser.page) => within.getByRole("button", { name, exact: true });
  const group = (name) => browser.page.getByRole("group", { name, exact: true });
  const sent = (type) => browser.page.evaluate((type) => window.sent.filter((command) => command.type === type), type);
  const forget = () => browser.page.evaluate(() => void (window.sent = []));
  const overlay = () => browser.page.getByLabel("Surface overlay", { exact: true }).inputValue();
  const opened = (name) => page.until(`${name} is open`, () => browser.page.title(), (title) => title.endsWith(name));
  const pressed = (name) => button(name).getAttribute("aria-pressed");
  const number = (label) => browser.page.locator("#settings").getByLabel(label, { exact: true });
  async function picture() {
    await browser.page.mouse.move(5, 5);
    await browser.page.locator("#toast").waitFor({ state: "hidden" });
    await page.drawn();
    return decodePng(await page.canvas("Surface view").screenshot());
  }
  async function middle() {
    const { x, y, width, height } = await page.canvas("Surface view").boundingBox();
    return { x: x + width / 2, y: y + height / 2, reach: Math.min(width, height) };
  }

  it("marks a changed parameter, and brings its default back", async () => {
    const length = number("Cut length");
    const usual = await length.inputValue();
    const reset = browser.page.getByRole("button", { name: `Reset Cut length to ${usual}`, exact: true });
    assert.ok(await reset.isHidden(), "nothing is changed yet");
    await length.fill("5");
    await length.press("Enter");
    await reset.waitFor({ state: "visible" });
    await reset.press("Enter");
    await page.until("the default", () => length.inputValue(), (value) => value === usual);
    await reset.waitFor({ state: "hidden" });
  });

  it("says where a number that was typed beyond the range has ended", async () => {
    const length = number("Cut length");
    const usual = await length.inputValue();
    const said = browser.page.locator("#settings .param").filter({ has: browser.page.getByLabel("Cut length", { exact: true }) }).getByText(/ is the (largest|smallest) value here\.$/);
    await length.fill(usual);
    await length.press("Enter");
    assert.equal(await said.count(), 0, "nothing is said of others");
    await length.fill("1e9");
    await length.press("Enter");
    await said.waitFor({ state: "visible" });
    const [most] = (await said.textContent()).split(" ");
    assert.equal(Number.parseFloat(most), Number.parseFloat(await length.inputValue()));
    await length.fill(usual);
    await length.press("Enter");
    await said.waitFor({ state: "detached" });
    await page.until("the default", () => length.inputValue(), (value) => value === usual);
  });

  it("remembers which groups are folded", async () => {
    const first = () => browser.page.locator("#settings details").first();
    assert.ok(await first().evaluate((node) => node.open), "the first group is open at first");
    await first().locator("summary").press("Enter");
    await browser.page.reload();
    await page.bring("ellipsoid.obj", asObj(MESH));
    assert.ok(!(await first().evaluate((node) => node.open)), "it is folded still");
    await first().locator("summary").press("Enter");
  });

  it("sets several parameters with a preset, two clicks from anywhere", async (t) => {
    await group("Presets").first().waitFor();
    const values = () => browser.page.locator("#settings :is(input, select)").evaluateAll((all) => all.map((one) => (one.type === "checkbox" ? one.checked : one.value)).join());
    const start = await values();
    await browser.page.getByLabel("Sample", { exact: true }).selectOption("ball");
    await opened("Ball");
    await button("Plush").click();
    await page.until("the preset is marked", () => pressed("Plush"), (state) => state === "true");
    const plush = await values();
    assert.notEqual(plush, start);
    await button("Bandage").click();
    await page.until("the other one is marked", () => pressed("Bandage"), (state) => state === "true");
    assert.equal(await pressed("Plush"), "false");
    assert.notEqual(await values(), plush, "another preset sets other values");
    await page.press("Undo");
    await page.until("one Undo takes all of it back", values, (now) => now === plush);
    await screenshot(browser.page, "tools-preset");
    await page.bring("ellipsoid.obj", asObj(MESH));
  });

  it("reaches the presets with the keyboard", async (t) => {
    await group("Presets").first().waitFor();
    await button("Plush").focus();
    await forget();
    await browser.page.keyboard.press("ArrowLeft");
    assert.deepEqual(await sent("apply_preset"), [], "an arrow chooses nothing yet");
    await browser.page.keyboard.press("ArrowRight");
    await browser.page.keyboard.press("Enter");
    await page.until("the preset is marked", () => pressed("Plush"), (state) => state === "true");
  });

  it("paints with the brush along the drag, without gaps", async (t) => {
    await button("Brush").first().waitFor();
    const kept = await overlay();
    await button("Brush").click();
    const tools = group("Brush tools");
    await tools.waitFor({ state: "visible" });
    await tools.getByLabel("Paint", { exact: true }).selectOption("penalty");
    await page.until("the field is shown", overlay, (id) => id === "penalty");
    const unpainted = await picture();
    await forget();
    const { x, y, reach } = await middle();
    await browser.page.mouse.move(x - 0.15 * reach, y);
    await browser.page.mouse.down();
    await browser.page.mouse.move(x + 0.15 * reach, y, { steps: 3 });
    await browser.page.mouse.up();
    const dabs = await page.until("the dabs are sent", () => sent("paint"), (list) => list.length >= 4);
    await page.until("there is something to clear", () => button("Clear").isEnabled(), Boolean);
    assert.deepEqual(dabs.map(({ begins }) => begins), dabs.map((_, i) => i === 0), "a stroke begins once");
    for (const { channel, value, face, radius } of dabs) {
      assert.ok(channel === "penalty" && value > 0 && value <= 1 && Number.isInteger(face) && radius > 0);
    }
    dabs.slice(1).forEach(({ place, radius }, i) => {
      const gap = Math.hypot(...place.map((c, k) => c - dabs[i].place[k]));
      assert.ok(gap < radius, `two dabs are ${gap} apart with a radius of ${radius}`);
    });
    await screenshot(browser.page, "tools-brush");
    assert.ok(difference(unpainted, await picture()) > 0.5, "the surface looks as before");

    await button("Clear").click();
    await page.until("it is clear", () => button("Clear").isDisabled(), Boolean);
    assert.ok(difference(unpainted, await picture()) < 0.5, "the stroke is gone");
    await browser.page.keyboard.press("Escape");
    await tools.waitFor({ state: "hidden" });
    await page.until("the overlay from before", overlay, (id) => id === kept);
  });

  it("has keys for the brush, and turns the surface with the other button", async (t) => {
    await button("Brush").first().waitFor();
    await page.canvas("Surface view").focus();
    await browser.page.keyboard.press("b");
    const tools = group("Brush tools");
    await tools.waitFor({ state: "visible" });
    await tools.getByLabel("Paint", { exact: true }).selectOption("penalty");
    await page.canvas("Surface view").focus();
    const size = async () => Number(await tools.getByLabel("Brush size", { exact: true }).inputValue());
    const first = await size();
    await browser.page.keyboard.press("]");
    assert.ok((await size()) > first, "] makes it larger");
    await browser.page.keyboard.press("[");
    assert.ok(Math.abs((await size()) - first) < 1e-6, "[ makes it smaller again");
    await browser.page.keyboard.press("e");
    assert.equal(await pressed("Erase"), "true");
    await browser.page.keyboard.press("e");
    await forget();
    await browser.page.keyboard.press("Enter");
    await page.until("Enter paints in the middle", () => sent("paint"), (list) => list.length === 1);
    const standing = await picture();
    const { x, y } = await middle();
    await browser.page.mouse.move(x, y);
    await browser.page.mouse.down({ button: "right" });
    await browser.page.mouse.move(x + 90, y + 30, { steps: 3 });
    await browser.page.mouse.up({ button: "right" });
    assert.equal((await sent("paint")).length, 1, "turning paints nothing");
    assert.ok(difference(standing, await picture()) > 0.5, "the surface has not turned");
    await button("Clear").click();
    await page.canvas("Surface view").focus();
    await browser.page.keyboard.press("Escape");
    await tools.waitFor({ state: "hidden" });
  });

  it("starts a patch where somebody clicks", async (t) => {
    await button("Brush").first().waitFor();
    await button("Brush").click();
    await button("Circle start").click();
    await forget();
    const { x, y } = await middle();
    await browser.page.mouse.click(x, y);
    const [circle] = await page.until("the place is sent", () => sent("place_circle"), (list) => list.length === 1);
    assert.ok(Number.isInteger(circle.face) && circle.place.every(Number.isFinite));
    assert.deepEqual(await sent("paint"), [], "the click paints nothing");
    assert.equal(await pressed("Circle start"), "false");
    await button("Brush").click();
    await page.status(/^Ready/);
  });

  it("hides seams from where one looks", async (t) => {
    await button("Hide seams from here").first().waitFor();
    await forget();
    await button("Hide seams from here").click();
    const [{ eye }] = await page.until("the eye is sent", () => sent("hide_from_camera"), (list) => list.length === 1);
    assert.ok(eye.length === 3 && Math.hypot(...eye) > 1, `the eye is at ${eye}`);
    await page.until("the penalty is shown", overlay, (id) => id === "penalty");
    assert.match(await browser.page.locator("#toast").textContent(), /cost more where this view sees them/);
    await screenshot(browser.page, "tools-hidden");
    await browser.page.getByLabel("Surface overlay", { exact: true }).selectOption("pieces");
  });

  it("lists the symmetries of the surface, and says where there are none", async (t) => {
    const section = browser.page.locator("#settings details", { has: browser.page.locator(".symmetry") });
    await section.first().waitFor();
    if (!(await section.evaluate((node) => node.open))) await section.locator("summary").click();
    const find = () => section.getByRole("button", { name: /^(Find symmetries|Search again)$/ });
    await find().click();
    const boxes = browser.page.getByRole("list", { name: "Symmetries" }).getByRole("checkbox");
    await page.until("mirror planes are found", () => boxes.count(), (count) => count >= 3);
    await forget();
    await boxes.first().check();
    const [{ ids }] = await page.until("the choice is sent", () => sent("set_symmetry"), (list) => list.length === 1);
    assert.equal(ids.length, 1);
    await screenshot(browser.page, "tools-symmetry");

    await page.bring("crooked.obj", asObj(CROOKED));
    await find().click();
    await browser.page.getByText("None found").waitFor({ state: "visible" });
  });

  it("folds the surface from its flat pieces, and ends that with the same button", async (t) => {
    await group("Presets").first().waitFor();
    await button("Fold preview").click();
    await page.until("the preview is on", () => pressed("Fold preview"), (state) => state === "true");
    const legend = browser.page.locator(".surface .legend");
    await page.until("its numbers", () => legend.textContent(), (text) => /Folded from the flat pieces.*off by/.test(text));
    await screenshot(browser.page, "tools-fold");
    await button("Fold preview").click();
    await page.until("the preview is off", () => pressed("Fold preview"), (state) => state === "false");
    await page.until("the legend from before", () => legend.textContent(), (text) => !text.includes("Folded"));
  });

  for (const width of [390, 360]) {
    it(`fits a phone of ${width} pixels with all tools out`, async () => {
      await browser.page.setViewportSize({ width, height: 780 });
      const brush = button("Brush");
      if (await brush.isVisible()) {
        if ((await brush.getAttribute("aria-pressed")) !== "true") await brush.click();
        const { height } = await group("Brush tools").boundingBox();
        assert.ok(height <= 48, `the tools wrap: ${height} px`);
      }
      await page.drawn();
      await screenshot(browser.page, `tools-phone-${width}`);
      const excess = () => browser.page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.equal(await excess(), 0, "the page scrolls sideways");
    });
  }

  it("has nothing to complain of in the browser's console", () => {
    assert.deepEqual(browser.troubles, []);
  });
});
