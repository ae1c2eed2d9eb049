// Twenty documents in a row in one page: what is left of each must not add up.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { PAGE, RENDERERS, open } from "./chromium.mjs";
import { asOff, asStl, ellipsoid, parseObj } from "./meshes.mjs";
import { Page } from "./page.mjs";

const [renderer] = RENDERERS;
const DOCUMENTS = 20;
/** After so many everything has been used once: caches are filled, and the code is compiled. */
const WARM = 3;
/** What the last may have more than the first. */
const GROWTH = 1.1;

const text = ellipsoid(3);
const mesh = parseObj(text);
/** By turns, so that none finds itself already open: the same surface, as three kinds of files. */
const FILES = [["one.obj", text], ["two.off", asOff(mesh)], ["three.stl", asStl(mesh)]];

describe("twenty documents in a row", { timeout: 600_000 }, () => {
  let browser, page, tab, devtools;
  let brought = 0;
  before(async () => {
    browser = await open(renderer);
    tab = browser.page;
    page = new Page(tab);
    // Objects on the graphics card that were made and not yet given back.
    await tab.addInitScript(() => {
      const live = (window.graphics = {});
      for (const kind of ["Buffer", "Texture", "Framebuffer", "Renderbuffer", "VertexArray", "Program", "Shader", "Sampler"]) {
        const [make, free] = [`create${kind}`, `delete${kind}`];
        const { [make]: made, [free]: freed } = WebGL2RenderingContext.prototype;
        live[kind] = 0;
        WebGL2RenderingContext.prototype[make] = function (...rest) {
          live[kind] += 1;
          return made.apply(this, rest);
        };
        WebGL2RenderingContext.prototype[free] = function (object) {
          if (object) live[kind] -= 1;
          return freed.call(this, object);
        };
      }
    });
    await page.visit(`${PAGE}?renderer=${renderer.query}&run=0&sample=car_hood`);
    await tab.waitForSelector("html[data-renderer]", { state: "attached" });
    devtools = await tab.context().newCDPSession(tab);
  });
  after(() => browser?.close());

  /** Bytes of the two wasm memories. Both modules are there already: importing them again gives the same instances. */
  async function wasm() {
    const viewer = await tab.evaluate(async () => (await (await import("./www/pkg/viewer.js")).default()).memory.buffer.byteLength);
    const [worker] = tab.workers();
    const engine = await worker.evaluate(async () => (await (await import(new URL("pkg/engine.js", location.href).href)).default()).memory.buffer.byteLength);
    return { viewer, engine };
  }

  async function measure() {
    await devtools.send("HeapProfiler.collectGarbage");
    const { usedSize: heap } = await devtools.send("Runtime.getHeapUsage");
    const { nodes, jsEventListeners: listeners, documents } = await devtools.send("Memory.getDOMCounters");
    const graphics = await tab.evaluate(() => Object.values(window.graphics).reduce((sum, count) => sum + count, 0));
    const canvases = await tab.evaluate(() => document.querySelectorAll("canvas").length);
    return { heap, nodes, listeners, documents, graphics, canvases, workers: tab.workers().length, ...(await wasm()) };
  }

  async function bring(documents) {
    for (let i = 0; i < documents; i += 1) {
      const [name, content] = FILES[brought % FILES.length];
      brought += 1;
      await page.chooseFile(name, content);
      await page.until(`${name} is open`, () => tab.title(), (title) => title.includes(name));
      await page.status(/^Ready/);
      for (const step of [1, 2]) {
        await page.pressAtOnce("Step");
        await page.status(new RegExp(`^(Paused at step ${step}|Converged after \\d+ steps?)\\b`));
      }
      // Documents that come faster than they are drawn need more at once: each is seen.
      await page.drawn();
    }
    return measure();
  }

  const grown = (before, now) => Object.keys(before).filter((what) => now[what] > GROWTH * before[what]);

  it("leave no more behind than the first three", async (t) => {
    const first = await bring(WARM);
    let last = await bring(DOCUMENTS - WARM);
    t.diagnostic(`after ${WARM}: ${JSON.stringify(first)}`);
    t.diagnostic(`after ${DOCUMENTS}: ${JSON.stringify(last)}`);
    assert.equal(last.workers, 1);
    assert.ok(last.graphics > 0, "the graphics are counted");
    let more = grown(first, last);
    if (more.length) {
      // The memory of a wasm module never shrinks: frames that once waited for a busy machine leave it larger for good.
      // What leaks grows with each document, so that as many again make it larger once more.
      const before = last;
      last = await bring(DOCUMENTS);
      t.diagnostic(`after ${2 * DOCUMENTS}: ${JSON.stringify(last)}`);
      const again = grown(before, last);
      more = more.filter((what) => again.includes(what));
    }
    assert.deepEqual(more.map((what) => `${what} from ${first[what]} to ${last[what]}`), []);
  });
});
