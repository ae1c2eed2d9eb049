// Cones as a person meets them: the price under a slider, cones set, moved, removed and typed by hand, the path, the
// comparison, the pattern that comes of it. What has to do with the glyphs, which are drawn, under each backend.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { RENDERERS, screenshot } from "./chromium.mjs";
import { asObj, ellipsoid, parseObj, uvAreas } from "./meshes.mjs";
import { begin } from "./page.mjs";
import { decodePng, difference } from "./pixels.mjs";

/** 642 vertices with six blunt arms: a convex surface would be all cones at every price. */
const BALL = parseObj(ellipsoid(3));
const DENTED = {
  ...BALL,
  vertices: BALL.vertices.map(([x, y, z]) => {
    // The ellipsoid's half axes are 1, 0.8 and 0.6.
    const reach = 0.25 + x ** 4 + (y / 0.8) ** 4 + (z / 0.6) ** 4;
    return [1.2 * reach * x, reach * y, 1.1 * reach * z];
  }),
};
/** Software graphics differ in the last bits of a pixel, and at the edges of lines. */
const ALIKE = 2;

const pictures = {};

/** Runs in the page: keeps what the page tells the engine, and how much of it waits for an answer. */
function recordCommands() {
  window.sent = [];
  window.mostOpen = 0;
  window.waits = [];
  let asked = 0;
  const answered = ({ data }) => {
    if (asked === 0 || !data.events?.some(({ type }) => type === "cones")) return;
    window.waits.push(performance.now() - asked);
    asked = 0;
  };
  const open = new Set();
  const post = Worker.prototype.postMessage;
  Worker.prototype.postMessage = function (message, ...rest) {
    if (message.type === "command") {
      window.sent.push(message.command);
      if (message.command.type === "set_parameter") {
        asked = performance.now();
        this.addEventListener("message", answered);
        if (open.size === 0) this.addEventListener("message", ({ data }) => data.type === "reply" && open.delete(data.id));
        open.add(message.id);
        window.mostOpen = Math.max(window.mostOpen, open.size);
      }
    }
    return post.call(this, message, ...rest);
  };
}

for (const renderer of RENDERERS) {
  describe(`cones with ${renderer.name}`, { timeout: 600_000 }, () => {
    let browser, page;
    before(async () => {
      ({ browser, page } = await begin(renderer, { query: "method=cones&run=0", name: "dented.obj", mesh: asObj(DENTED), script: recordCommands, pixels: 1, ready: /^(Ready$|Converged)/ }));
    });
    after(() => browser?.close());

    const tab = (name) => browser.page.getByRole("tab", { name, exact: true });
    const button = (name) => browser.page.getByRole("button", { name, exact: true });
    const table = () => browser.page.getByRole("table", { name: "Cones" });
    const rows = () => table().locator("tbody tr").count();
    const sent = (type) => browser.page.evaluate((type) => window.sent.filter((command) => command.type === type), type);
    const forget = () => browser.page.evaluate(() => void ([window.sent, window.mostOpen, window.waits] = [[], 0, []]));
    const slider = () => browser.page.locator("#settings .path + .param input[type=range]");
    const angles = () => table().getByLabel(/^Angle of cone \d+$/);
    /** How many cones are marked as fixed by hand; where there is one more or less, the optimum may have other cones as well. */
    const fixed = () => table().getByRole("img", { name: "Its angle is fixed by hand" }).count();
    const edited = () => browser.page.getByText("Edited by hand", { exact: true });
    const path = () => browser.page.getByRole("img", { name: /^Number of cones over λ/ });
    /** Waits until the engine rests, and gives how many cones there are then. */
    async function rest() {
      await page.status(/^(Ready|Paused|Converged)/);
      await browser.page.waitForTimeout(200);
      return rows();
    }
    /** Vertices that are cones, before neighbours are merged. */
    const raw = async () => Number(/([\d\u202f]+) cones? at λ/.exec(await path().getAttribute("aria-label"))?.[1].replaceAll("\u202f", ""));
    async function restRaw() {
      await rest();
      return raw();
    }
    const middle = async () => {
      const { x, y, width, height } = await page.canvas("Surface view").boundingBox();
      return { x: x + width / 2, y: y + height / 2 };
    };
    const lit = () => table().locator("tbody tr.on").count();
    /** Points at a cone that is seen: the first one with a label, marked ones before all, whose glyph lies beside that on one of four sides. */
    async function pointAtLabelled() {
      const rect = browser.page.locator(".surface .cone-labels g:not([hidden]) rect").first();
      const box = await rect.boundingBox();
      const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
      const places = [11, 14, 8].flatMap((gap) => [[box.x - gap, y], [box.x + box.width + gap, y], [x, box.y + box.height + gap], [x, box.y - gap]]);
      for (const [left, top] of places) {
        await browser.page.mouse.move(left, top);
        await browser.page.waitForTimeout(400);
        if ((await lit()) === 1) return { x: left, y: top };
      }
      throw new Error("no row is lit beside a label");
    }
    async function picture() {
      await browser.page.mouse.move(5, 5);
      await browser.page.locator("#toast").waitFor({ state: "hidden" });
      await page.drawn();
      return decodePng(await page.canvas("Surface view").screenshot());
    }

    it("is opened by its address", async () => {
      await page.until("the tab is chosen", () => tab("Cones").getAttribute("aria-selected"), (value) => value === "true");
      assert.equal(await tab("Cut flow").getAttribute("aria-selected"), "false");
      await page.press("Run");
      await page.status(/^Converged after \d+ steps?/);
      const count = await rest();
      assert.ok(count >= 2, `${count} cones`);
      assert.match(await path().getAttribute("aria-label"), /\d+ cones? at λ/);
      assert.match(await browser.page.locator("#note").textContent(), /λ_max.*, residual .*, gap /);
      assert.ok((await page.measure("Pieces")) >= 1);
      await screenshot(browser.page, `cones-${renderer.name}`);
      pictures[renderer.name] = await picture();
    });

    it("turns a switch where its text is clicked, changed or not", async () => {
      const merge = browser.page.getByRole("switch", { name: "Merge clusters", exact: true });
      const text = browser.page.locator("#settings label").filter({ has: merge }).getByText("Merge clusters", { exact: true });
      const reset = browser.page.getByRole("button", { name: "Reset Merge clusters to on", exact: true });
      for (const isOn of [false, true, false]) {
        await text.click();
        await page.until("it is turned", () => merge.isChecked(), (value) => value === isOn);
        await reset.waitFor({ state: isOn ? "hidden" : "visible" });
      }
      await reset.click();
      await page.until("the default is back", () => merge.isChecked(), (value) => value);
      await rest();
    });

    it("adds a cone where somebody clicks, takes it elsewhere, and removes it", async () => {
      const count = await rest();
      await forget();
      await button("Add cone").click();
      await browser.page.getByLabel("Angle of new cones", { exact: true }).fill("0.5");
      // The tools take some room: the middle is another one afterwards.
      const open = await middle();
      await browser.page.mouse.click(open.x, open.y);
      const [added] = await page.until("the place is sent", () => sent("add_cone"), (list) => list.length === 1);
      assert.ok(Number.isInteger(added.face) && added.place.every(Number.isFinite) && Math.abs(added.angle - Math.PI / 2) < 1e-12);
      await page.until("it is there", fixed, (now) => now === 1);
      await rest();
      await button("Add cone").click();

      const still = await picture();
      // It was set on the nearest vertex and is the chosen one.
      const { x, y } = await pointAtLabelled();
      assert.ok(await table().locator("tbody tr.on.chosen").isVisible());
      await browser.page.mouse.down();
      await browser.page.mouse.move(x + 40, y + 10, { steps: 4 });
      await browser.page.mouse.up();
      const [moved] = await page.until("the new place is sent", () => sent("move_cone"), (list) => list.length === 1);
      const way = Math.hypot(...moved.place.map((c, k) => c - added.place[k]));
      assert.ok(way > 0.02, `it has moved by ${way}`);
      await rest();
      assert.ok(difference(still, await picture()) > 0.02, "the picture shows it");
      await screenshot(browser.page, `cones-moved-${renderer.name}`);

      // The cone that was moved is the chosen one.
      await page.canvas("Surface view").focus();
      await browser.page.keyboard.press("Delete");
      await page.until("the removal is sent", () => sent("remove_cone"), (list) => list.length === 1);
      await page.until("it is gone", fixed, (now) => now === 0);
      await page.press("Undo");
      await page.until("Undo brings it back", fixed, (now) => now === 1);
      await rest();
      await button("Drop edits").click();
      await page.until("the optimum is back", rest, (now) => now === count);
      await edited().waitFor({ state: "hidden" });
    });

    it("lights the row of the cone under the pointer, and the other way round", async () => {
      await rest();
      await pointAtLabelled();
      assert.match(await browser.page.locator(".surface .tip").textContent(), /^Cone \d+ −?\d\.\d\d/);
      const pointed = decodePng(await page.canvas("Surface view").screenshot());
      await browser.page.mouse.move(5, 5);
      await page.until("no row is lit", lit, (count) => count === 0);
      await table().locator("tbody tr").first().hover();
      await page.until("the row under the pointer is lit", lit, (count) => count === 1);
      assert.ok(difference(pointed, await picture()) > 0, "the glyph looks as before");
    });

    if (renderer !== RENDERERS[0]) {
      it("has nothing to complain of in the browser's console", () => assert.deepEqual(browser.troubles, []));
      return;
    }

    // The engine and the panels are the same under either backend.

    it("follows the slider of λ, one question at a time", async () => {
      const before = await restRaw();
      await forget();
      await slider().scrollIntoViewIfNeeded();
      const box = await slider().boundingBox();
      const y = box.y + box.height / 2;
      const at = await slider().evaluate((input) => Number(input.value) / Number(input.max));
      const place = (part) => box.x + 6 + (box.width - 12) * part;
      await browser.page.mouse.move(place(at), y);
      await browser.page.mouse.down();
      for (let i = 1; i <= 30; i += 1) await browser.page.mouse.move(place(at * (1 - 0.5 * (i / 30))), y);
      await browser.page.mouse.up();
      const count = await page.until("other cones at a lower price", restRaw, (count) => count !== before);
      const asked = await sent("set_parameter");
      assert.ok(asked.length >= 2 && asked.every(({ id }) => id === "lambda"), JSON.stringify(asked));
      assert.equal(await browser.page.evaluate(() => window.mostOpen), 1, "a question waits for the answer before it");
      await page.until("the slider is let go", () => sent("hold"), (holds) => holds.length === 2);
      assert.deepEqual((await sent("hold")).map((command) => command.is_held), [true, false]);
      const waits = (await browser.page.evaluate(() => window.waits)).sort((a, b) => a - b);
      console.log(`# ${renderer.name}: cones follow the slider after ${Math.round(waits[waits.length >> 1])} ms (median of ${waits.length})`);
      await page.press("Undo");
      await page.until("the cones from before", restRaw, (now) => now === before && now !== count);
    });

    it("traces the path, and shows it above the slider and as a curve", async () => {
      await rest();
      await button("Trace path").click();
      await page.until("the path is complete", () => button(/^Trace/).count(), async () => (await button("Stop").isHidden()) && (await button("Trace path").isHidden()));
      await page.status(/^(Ready|Paused|Converged)/);
      assert.match(await path().getAttribute("aria-label"), /from \d+ at .* to [\d\u202f]+ at/);
      assert.ok((await browser.page.locator("#distortion-plot path.first").count()) === 1, "there is a curve");
      await screenshot(browser.page, `cones-path-${renderer.name}`);
      const plot = browser.page.getByLabel("Distortion plot", { exact: true });
      await plot.selectOption("price");
      const lines = browser.page.locator("#distortion-plot path:is(.first, .second)");
      await page.until("two curves", () => lines.count(), (count) => count === 2);
      assert.match(await browser.page.locator("#distortion-plot svg").getAttribute("aria-label"), /^Distortion and total angle over λ: at λ .* ∫u² .*, total angle .*π$/);
      await screenshot(browser.page, `cones-price-${renderer.name}`);
      await plot.selectOption("angle");
      await page.until("one curve", () => lines.count(), (count) => count === 1);
    });

    it("takes an angle in units of π, and sets it free again", async () => {
      await rest();
      await angles().first().click();
      await angles().first().fill("1/3");
      await angles().first().press("Enter");
      const [command] = await page.until("the angle is sent", () => sent("set_cone_angle"), (list) => list.length === 1);
      assert.ok(Math.abs(command.angle - Math.PI / 3) < 1e-12);
      await edited().waitFor({ state: "visible" });
      const field = () => table().getByLabel(`Angle of cone ${command.cone + 1}`, { exact: true });
      await page.until("the angle is kept", () => field().inputValue(), (value) => value === "0.33");
      await angles().first().click();
      await angles().first().fill("nonsense");
      await angles().first().press("Enter");
      assert.equal((await sent("set_cone_angle")).length, 1, "nonsense is not sent");
      await page.press("Undo");
      await edited().waitFor({ state: "hidden" });
    });

    it("is worked with the keyboard alone", async () => {
      const count = await rest();
      await forget();
      await table().locator("tbody button[tabindex='0']").first().focus();
      await browser.page.keyboard.press("ArrowDown");
      await browser.page.keyboard.press("Enter");
      await page.until("the angle has the focus", () => browser.page.evaluate(() => document.activeElement.getAttribute("aria-label")), (label) => /^Angle of cone/.test(label ?? ""));
      await browser.page.keyboard.press("Escape");
      await page.canvas("Surface view").focus();
      await browser.page.keyboard.press("m");
      await page.until("the chosen cone goes to the middle", () => sent("move_cone"), (list) => list.length === 1);
      await rest();
      await browser.page.keyboard.press("a");
      await page.canvas("Surface view").focus();
      await browser.page.keyboard.press("ArrowLeft");
      await browser.page.keyboard.press("ArrowLeft");
      await browser.page.keyboard.press("Enter");
      await page.until("a cone is added in the middle", () => sent("add_cone"), (list) => list.length === 1);
      await page.until("it is there", () => table().getByRole("img", { name: /^(Placed|Its angle is fixed) by hand/ }).count(), (now) => now >= 1);
      await rest();
      await browser.page.keyboard.press("Escape");
      assert.equal(await button("Add cone").getAttribute("aria-pressed"), "false");
      await button("Drop edits").click();
      await page.until("the optimum is back", rest, (now) => now === count);
    });

    it("puts the greedy cones beside the optimum", async () => {
      await rest();
      await button("Compare with greedy").click();
      const compared = browser.page.getByRole("table", { name: "Comparison" });
      await compared.waitFor({ state: "visible" });
      const heads = await compared.getByRole("columnheader").allTextContents();
      assert.ok(heads.length >= 3, heads.join());
      const left = await compared.getByRole("row").filter({ has: browser.page.getByRole("rowheader", { name: "∫u²", exact: true }) }).getByRole("cell").allTextContents();
      assert.ok(left.every((text) => Number(text) > 0), left.join());
      await screenshot(browser.page, `cones-compared-${renderer.name}`);
    });

    it("exports a chart without flips, cut open", async () => {
      await rest();
      const mesh = parseObj(await page.export("UV mesh (OBJ)"));
      assert.equal(mesh.triangles.length >= BALL.triangles.length, true);
      const areas = uvAreas(mesh);
      const flipped = areas.filter((area) => !(area > 0)).length;
      assert.equal(flipped, await page.measure("Flipped triangles"));
      assert.ok(mesh.uvs.length > mesh.vertices.length, "a cone is reached by a seam, whose vertices have two places");
    });

    it("is told by a link, and lives beside the cut flow", async () => {
      await rest();
      await button("Share").click();
      const link = new URL(await browser.page.getByLabel("Link to this setting", { exact: true }).inputValue());
      assert.equal(link.searchParams.get("method"), "cones");
      assert.ok(link.searchParams.has("p.lambda"), link.search);
      await browser.page.keyboard.press("Escape");
      const count = await rest();
      await tab("Cut flow").click();
      await page.until("the cut flow is chosen", () => tab("Cut flow").getAttribute("aria-selected"), (value) => value === "true");
      await browser.page.getByRole("table", { name: "Pieces" }).waitFor({ state: "visible" });
      assert.ok(await table().isHidden());
      await page.status(/^(Ready|Paused|Converged)/);
      await tab("Cones").click();
      await table().waitFor({ state: "visible" });
      await page.until("the cones are back", rest, (now) => now === count);
    });

    it("fits a phone", async () => {
      await browser.page.setViewportSize({ width: 390, height: 844 });
      await browser.page.getByRole("tab", { name: "Distortion", exact: true }).waitFor();
      const sheet = browser.page.getByRole("tablist", { name: "Sheet" });
      for (const name of ["Cones", "Distortion", "Parameters"]) {
        await sheet.getByRole("tab", { name, exact: true }).click();
        await screenshot(browser.page, `cones-phone-${name.toLowerCase()}-${renderer.name}`);
        const excess = await browser.page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
        assert.equal(excess, 0, `${name}: the page scrolls sideways`);
      }
    });

    it("has nothing to complain of in the browser's console", () => {
      assert.deepEqual(browser.troubles, []);
    });
  });
}

describe("cones with both backends", () => {
  it("are drawn alike", (t) => {
    const [one, other] = RENDERERS.map(({ name }) => pictures[name]);
    assert.ok(one && other, "a backend has drawn nothing");
    const mean = difference(one, other);
    t.diagnostic(`mean difference ${mean.toFixed(2)} of 255`);
    assert.ok(mean <= ALIKE, `they differ by ${mean.toFixed(2)} of 255 in the mean`);
  });
});
