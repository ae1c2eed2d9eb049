// Learn, the glossary and the welcome: what explains the page. Under one backend: what is drawn is compared elsewhere.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { COARSE, PAGE, RENDERERS, open, screenshot } from "./chromium.mjs";
import { ellipsoid } from "./meshes.mjs";
import { Page } from "./page.mjs";

const [renderer] = RENDERERS;
const ADDRESS = `${PAGE}?renderer=${renderer.query}&run=0`;
const METHODS = { cutflow: "Cut flow", cones: "Cones", phasefield: "Phase field", developable: "Developable patches" };
const STAGES = [
  ["Curvature K", "curvature"],
  ["Cut mesh", "pieces"],
  ["Scale factor u", "u"],
  ["Flux ∂u/∂n", "flux"],
  ["Velocity v", "velocity"],
  ["Extended velocity", "extension"],
  ["New φ", "moved"],
  ["Redistanced φ", "redistanced"],
  ["New cut, energy check", "pieces"],
];
/** Smaller than this nobody reads it from the last row. */
const READABLE_PX = 15;

describe("Learn", { timeout: 600_000 }, () => {
  let browser, page;
  const foreign = [];
  before(async () => {
    browser = await open(renderer, COARSE);
    page = new Page(browser.page);
    browser.page.on("request", (request) => {
      const address = request.url();
      if (/^https?:/.test(address) && !address.startsWith(new URL(PAGE).origin)) foreign.push(address);
    });
    // What the engine and the page tell each other.
    await browser.page.addInitScript(() => {
      Object.assign(window, { sent: [], specs: {}, fields: {} });
      let method = "cutflow";
      window.Worker = class extends Worker {
        constructor(...rest) {
          super(...rest);
          this.addEventListener("message", ({ data }) => {
            for (const event of data.events ?? []) {
              if (event.type === "methods") method = event.current;
              if (event.type === "parameters") window.specs[event.method] = event.specs.map(({ id }) => id);
              if (event.type === "fields") window.fields[method] = event.options.map(({ id }) => id);
            }
          });
        }
        postMessage(message, ...rest) {
          if (message.type === "command") window.sent.push(message.command);
          return super.postMessage(message, ...rest);
        }
      };
    });
    await page.visit(`${ADDRESS}&sample=none`);
    await page.bring("ellipsoid.obj", ellipsoid(3));
  });
  after(() => browser?.close());

  const button = (name, within = browser.page) => within.getByRole("button", { name, exact: true });
  const lesson = () => browser.page.locator("#lesson");
  const key = (name) => browser.page.keyboard.press(name);
  const overlay = () => browser.page.getByLabel("Surface overlay", { exact: true }).inputValue();
  const stage = (i, of) => page.until(`stage ${i}`, () => lesson().textContent(), (text) => text.startsWith(`Stage ${i} of ${of ?? ""}`));
  /** The status line is out of sight here. */
  const step = (n) => page.until(`step ${n}`, () => browser.page.locator("#learn-step").textContent(), (text) => text.startsWith(`Step ${n} on `));
  const at = async () => Number(/^Stage (\d+)/.exec(await lesson().textContent())?.[1]);
  const number = (label, within) => browser.page.locator(within).getByLabel(label, { exact: true });
  const lessons = () => browser.page.evaluate(() => [...document.getElementById("lessons").content.querySelectorAll("article")].map((article) => ({
    method: article.dataset.method ?? "cutflow",
    title: article.dataset.title,
    question: article.querySelector("h3").textContent,
    fields: article.dataset.fields.split(" "),
    parameters: article.dataset.parameters?.split(" ") ?? [],
    words: [...article.querySelectorAll("dfn")].map((dfn) => dfn.title || dfn.textContent),
  })));
  async function choose(method) {
    await browser.page.getByRole("tab", { name: METHODS[method], exact: true }).click();
    await page.until(`the method ${method}`, () => browser.page.locator("html").getAttribute("data-method"), (now) => now === method);
    await page.status(/^(Ready|Paused|Converged)/);
  }
  async function learn() {
    await button("Learn").click();
    // It opens at the stage where it was left.
    await browser.page.locator("#stages button").first().click();
    await stage(1);
  }

  it("explains a step of the cut flow in nine stages, each with its formula and its field", async () => {
    await page.press("Step");
    await page.status(/^Paused at step 1\b/);
    const kept = await overlay();
    await learn();
    for (const [i, [title, field]] of STAGES.entries()) {
      await stage(i + 1, STAGES.length);
      assert.match(await browser.page.locator("#stages [aria-current=step]").textContent(), new RegExp(title.replace("/", ".")));
      await page.until(`the field of ${title}`, overlay, (id) => id === field);
      await page.until(`the numbers of ${title}`, () => lesson().locator("table tr").count(), (count) => count > 0);
      const { excess } = await browser.page.evaluate(sizes);
      assert.equal(excess[2], 0, `${title}: a formula is wider than its column`);
      await screenshot(browser.page, `learn-${i + 1}`);
      if (i + 1 < STAGES.length) await lesson().locator(".nav .primary").press("Enter");
    }
    await key("Escape");
    await page.until("the overlay from before", overlay, (id) => id === kept);
  });

  it("has stages that look as if they could be chosen, before they were", async () => {
    await learn();
    for (const theme of ["light", "dark"]) {
      await browser.page.emulateMedia({ colorScheme: theme });
      const ratios = await browser.page.evaluate(contrasts);
      assert.ok(ratios.length > 0);
      // Three to one for shapes, four and a half for text: the figures of WCAG 2.
      for (const { text, eye } of ratios) assert.ok(text >= 4.5 && eye >= 3, `${theme}: text ${text.toFixed(1)}, picture ${eye.toFixed(1)}`);
    }
    await browser.page.emulateMedia({ colorScheme: "light" });
    await key("Escape");
  });

  it("sets parameters that stay in step with those of the panel, both ways", async () => {
    const [panel, here] = ["#settings", "#lesson"];
    await number("Cut length", panel).fill("3");
    await number("Cut length", panel).press("Enter");
    await learn();
    await browser.page.locator("#stages button", { hasText: "New φ" }).click();
    assert.equal(await number("Cut length", here).inputValue(), "3.00");
    await browser.page.evaluate(() => void (window.sent = []));
    await number("Cut length slider", here).press("ArrowRight");
    const [command] = await page.until("it is sent", () => browser.page.evaluate(() => window.sent.filter(({ type }) => type === "set_parameter")), (list) => list.length > 0);
    assert.ok(command.id === "length" && command.value > 3, JSON.stringify(command));
    await page.until("the panel has it too", () => number("Cut length", panel).inputValue(), (text) => Number(text) === Number(command.value.toPrecision(3)));
    // Changes of one parameter in a row are one step of the history.
    await button("Undo").click();
    await page.until("Undo is seen here", () => number("Cut length", here).inputValue(), (text) => text === "2.00");
    await number("Cut length slider", here).press("ArrowRight");
    await page.until("the panel follows", () => number("Cut length", panel).inputValue(), (text) => Number(text) > 2);
    await button("Reset Cut length to 2.00", lesson()).click();
    await page.until("the dot brings its default back", () => number("Cut length", panel).inputValue(), (text) => text === "2.00");
    await button("Close Learn").click();
    assert.equal(await lesson().textContent(), "", "nothing of a lesson stays behind");
  });

  it("turns stages with a press of Play where motion is reduced, and by itself where it is not", async () => {
    await learn();
    const play = button("Play stages");
    await play.click();
    await stage(2);
    assert.equal(await play.getAttribute("aria-pressed"), "false");
    await browser.page.emulateMedia({ reducedMotion: "no-preference" });
    // A stage is shown as long as it takes to read: here time goes ten times as fast.
    await browser.page.evaluate(() => {
      const slow = setTimeout;
      window.setTimeout = (call, wait, ...rest) => slow(call, wait / 10, ...rest);
      addEventListener("slow again", () => (window.setTimeout = slow), { once: true });
    });
    await play.click();
    assert.equal(await play.getAttribute("aria-pressed"), "true");
    await stage(3);
    await key("PageUp");
    await stage(2);
    assert.equal(await play.getAttribute("aria-pressed"), "false", "who turns by hand is left alone");
    await browser.page.evaluate(() => dispatchEvent(new Event("slow again")));
    await browser.page.emulateMedia({ reducedMotion: "reduce" });
    await key("Escape");
  });

  it("says when no step is left, and offers to begin anew", async () => {
    await page.press("Run");
    await page.status(/^Converged/);
    await learn();
    await browser.page.getByText("Converged: Reset begins anew.").waitFor({ state: "visible" });
    assert.ok(await button("Take one step").isHidden());
    await button("Reset: begin anew").press("Enter");
    await step(0);
    await button("Take one step").waitFor({ state: "visible" });
    assert.equal(await browser.page.evaluate(() => document.activeElement.id), "learn-once", "the focus goes on at its heir");
    await button("Take one step").press("Enter");
    await step(1);
    await key("Escape");
  });

  for (const method of Object.keys(METHODS)) {
    it(`asks of the engine what it has, and fits a projector: ${METHODS[method]}`, async () => {
      await browser.page.setViewportSize({ width: 1280, height: 720 });
      if (method !== "cutflow") await choose(method);
      const own = (await lessons()).filter((lesson) => lesson.method === method);
      const { specs, fields } = await browser.page.evaluate((method) => ({ specs: window.specs[method], fields: window.fields[method] }), method);
      for (const { title, question, fields: shown, parameters } of own) {
        assert.match(question, /\?$/, `${title} asks something`);
        assert.deepEqual(shown.filter((id) => !fields.includes(id)), [], `fields of ${title}`);
        assert.deepEqual(parameters.filter((id) => !specs.includes(id)), [], `parameters of ${title}`);
      }
      await learn();
      await button("Lecture").click();
      for (const [i, { title }] of own.entries()) {
        await stage(i + 1, own.length);
        assert.equal(await lesson().locator("math.key").count(), 1, `${title} has its formula`);
        assert.ok((await lesson().locator("table tr").count()) > 0, `${title} has numbers`);
        const seen = await browser.page.evaluate(sizes);
        assert.deepEqual(seen.excess, [0, 0, 0, 0], `${title} is seen whole`);
        assert.ok(seen.type >= READABLE_PX, `${title} is written ${seen.type} px high`);
        await key(i % 2 ? "PageDown" : "ArrowRight");
      }
      assert.equal(await at(), own.length, "there is nothing behind the last stage");
      await screenshot(browser.page, `lecture-${method}`);
      assert.ok(await button("Run").isVisible() && (await browser.page.locator("#measures").isHidden()));
      await key("ArrowLeft");
      await stage(own.length - 1);
      await key("Escape");
      assert.equal(await button("Lecture").getAttribute("aria-pressed"), "false", "Escape ends the lecture first");
      await key("Escape");
      assert.ok(await browser.page.locator("#learn-panel").isHidden());
    });
  }

  it("names its papers, and asks nothing of them by itself", async () => {
    await learn();
    await lesson().locator(".papers summary").click();
    const links = await lesson().locator(".papers a").evaluateAll((list) => list.map(({ href, target, rel }) => ({ href, target, rel })));
    assert.ok(links.length > 0);
    for (const { href, target, rel } of links) {
      assert.match(href, /^https:\/\/doi\.org\/10\.1145\/\d+\.\d+$/);
      assert.deepEqual([target, rel], ["_blank", "noopener"]);
    }
    assert.match(await lesson().locator(".papers").textContent(), /Wang: Computing Length-Preserved Free Boundary/);
    await key("Escape");
    assert.deepEqual(foreign, []);
  });

  it("has a glossary with every word of the lessons, which is searched and left by the keyboard", async () => {
    const names = await browser.page.locator("#glossary-dialog dt").allTextContents();
    assert.ok(names.length >= 40, `${names.length} words`);
    assert.equal(new Set(names.map((name) => name.toLowerCase())).size, names.length, "a word stands twice");
    const linked = (await lessons()).flatMap(({ words }) => words);
    assert.ok(linked.length >= 30, `${linked.length} words of lessons`);
    assert.deepEqual(linked.filter((word) => !names.some((name) => name.toLowerCase() === word.toLowerCase())), []);

    await button("Glossary").press("Enter");
    const dialog = browser.page.getByRole("dialog", { name: "Glossary" });
    await dialog.waitFor({ state: "visible" });
    const shown = () => dialog.locator("dl > div:not([hidden]) dt").allTextContents();
    await browser.page.keyboard.type("GAUSS bonnet");
    assert.deepEqual(await shown(), ["Gauss–Bonnet"]);
    await dialog.getByLabel("Search the glossary").fill("cut");
    assert.deepEqual((await shown()).slice(0, 2), ["Cut", "Cut flow"], "what begins with it comes first");
    await dialog.getByLabel("Search the glossary").fill("xyzzy");
    assert.match(await dialog.textContent(), /No word matches/);
    await key("Escape");
    await dialog.waitFor({ state: "hidden" });
    assert.equal(await browser.page.evaluate(() => document.activeElement.id), "glossary");

    await learn();
    const word = lesson().getByRole("button", { name: "developable" }).or(lesson().getByRole("button", { name: "VSA" })).first();
    const name = await word.textContent();
    await word.press("Enter");
    await dialog.waitFor({ state: "visible" });
    assert.equal((await dialog.locator("[data-chosen] dt").textContent()).toLowerCase(), name.toLowerCase());
    await screenshot(browser.page, "glossary");
    await key("Escape");
    await dialog.waitFor({ state: "hidden" });
    assert.ok(await browser.page.locator("#learn-panel").isVisible(), "Escape leaves the glossary only");
    await key("Escape");
  });

  for (const width of [390, 360]) {
    it(`fits a phone of ${width} pixels`, async () => {
      await browser.page.setViewportSize({ width, height: 780 });
      await learn();
      for (let i = 0; i < (await browser.page.locator("#stages button").count()); i += 1) {
        await browser.page.locator("#stages button").nth(i).click();
        await stage(i + 1);
        const [excess] = (await browser.page.evaluate(sizes)).excess;
        assert.equal(excess, 0, `stage ${i + 1} scrolls sideways`);
      }
      await screenshot(browser.page, `learn-phone-${width}`);
      await button("Close Learn").click();
    });
  }

  it("has nothing to complain of in the browser's console", () => {
    assert.deepEqual(browser.troubles, []);
  });
});

describe("the welcome", { timeout: 600_000 }, () => {
  let browser, page;
  before(async () => {
    browser = await open(renderer, COARSE);
    page = new Page(browser.page);
  });
  after(() => browser?.close());
  const card = () => browser.page.getByRole("complementary", { name: "Welcome" });

  it("does not stand in the way of a link to something in particular", async () => {
    await page.visit(`${ADDRESS}&sample=ball`);
    assert.equal(await card().count(), 0);
  });

  it("says on the first visit what one sees, covers nothing, and stays away once it was closed", async () => {
    await page.visit(ADDRESS);
    await card().waitFor({ state: "visible" });
    const sentences = (await card().locator("p").first().textContent()).split(/(?<=\.)\s/);
    assert.equal(sentences.length, 3);
    const [box, view] = [await card().boundingBox(), await page.canvas("Surface view").boundingBox()];
    assert.ok(box.x + box.width <= view.x, "it covers the surface");
    await screenshot(browser.page, "welcome");
    const chooser = browser.page.waitForEvent("filechooser");
    await page.press("Choose your mesh");
    await chooser;
    await page.press("Close welcome");
    assert.equal(await card().count(), 0);
    await page.visit(ADDRESS);
    assert.equal(await card().count(), 0, "it came back");
  });

  it("goes when somebody opens a mesh", async () => {
    await browser.page.evaluate(() => localStorage.clear());
    await page.visit(ADDRESS);
    await card().waitFor({ state: "visible" });
    await page.dropFile("ellipsoid.obj", ellipsoid(2));
    await card().waitFor({ state: "detached" });
    assert.deepEqual(browser.troubles, []);
  });
});

/** Runs in the page: by how much the page and the lesson are wider and higher than what is seen of them, and the size of type. */
function sizes() {
  const lesson = document.getElementById("lesson");
  const page = document.documentElement;
  const excess = [page.scrollWidth - innerWidth, page.scrollHeight - innerHeight, lesson.scrollWidth - lesson.clientWidth, lesson.scrollHeight - lesson.clientHeight];
  return { excess: excess.map((pixels) => Math.max(0, pixels)), type: Number.parseFloat(getComputedStyle(lesson.querySelector("p:nth-of-type(2)")).fontSize) };
}

/** Runs in the page: contrast of the texts and the pictures of Learn's stages with what lies behind them. */
function contrasts() {
  const paint = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const luminance = (colours) => {
    paint.clearRect(0, 0, 1, 1);
    for (const colour of colours) {
      paint.fillStyle = colour;
      paint.fillRect(0, 0, 1, 1);
    }
    const [r, g, b] = [...paint.getImageData(0, 0, 1, 1).data].map((x) => (x / 255 <= 0.04045 ? x / 255 / 12.92 : ((x / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ratio = (front, back) => {
    const [a, b] = [luminance(front), luminance(back)].sort((x, y) => y - x);
    return (a + 0.05) / (b + 0.05);
  };
  const ground = getComputedStyle(document.body).backgroundColor;
  const behind = (node) => [ground, getComputedStyle(node).backgroundColor];
  return [...document.querySelectorAll("#stages li:not([aria-current]) button")].map((button) => ({
    text: ratio([getComputedStyle(button.querySelector("span")).color], behind(button)),
    eye: ratio([getComputedStyle(button.querySelector(".thumb")).color], behind(button.querySelector(".thumb"))),
  }));
}
