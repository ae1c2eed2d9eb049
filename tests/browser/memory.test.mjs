// Twenty documents in a row in one page: what is left of each must not add up.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { PAGE, RENDERERS, open } from "./chromium.mjs";
import { Holdings, countGraphics, grown } from "./holdings.mjs";
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
  let browser, page, tab, holdings;
  let brought = 0;
  before(async () => {
    browser = await open(renderer);
    tab = browser.page;
    page = new Page(tab);
    await countGraphics(tab);
    await page.visit(`${PAGE}?renderer=${renderer.query}&run=0&sample=car_hood`);
    await tab.waitForSelector("html[data-renderer]", { state: "attached" });
    holdings = await Holdings.of(tab);
  });
  after(() => browser?.close());

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
    return holdings.measure();
  }

  it("leave no more behind than the first three", async (t) => {
    const first = await bring(WARM);
    let last = await bring(DOCUMENTS - WARM);
    t.diagnostic(`after ${WARM}: ${JSON.stringify(first)}`);
    t.diagnostic(`after ${DOCUMENTS}: ${JSON.stringify(last)}`);
    assert.equal(last.workers, 1);
    assert.ok(last.graphics > 0, "the graphics are counted");
    let more = grown(first, last, GROWTH);
    if (more.length) {
      // The memory of a wasm module never shrinks: frames that once waited for a busy machine leave it larger for good.
      // What leaks grows with each document, so that as many again make it larger once more.
      const before = last;
      last = await bring(DOCUMENTS);
      t.diagnostic(`after ${2 * DOCUMENTS}: ${JSON.stringify(last)}`);
      const again = grown(before, last, GROWTH);
      more = more.filter((what) => again.includes(what));
    }
    assert.deepEqual(more.map((what) => `${what} from ${first[what]} to ${last[what]}`), []);
  });
});
