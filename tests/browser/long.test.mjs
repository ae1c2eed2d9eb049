// Steps upon steps in one page: hours of them hold what minutes hold. Some hundreds on a small mesh; with CUTFLOW_HOURS in the
// environment (`cargo xtask soak`) so many hours of them on 20 480 triangles.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { PAGE, PATIENCE_MS, RENDERERS, open } from "./chromium.mjs";
import { Holdings, countGraphics, grown } from "./holdings.mjs";
import { ellipsoid } from "./meshes.mjs";
import { Page } from "./page.mjs";

const [renderer] = RENDERERS;
const HOURS = Number(process.env.CUTFLOW_HOURS ?? 0);
const LEVEL = HOURS ? 5 : 3;
/** Undo goes back 40 changes, of which a run takes three: only then is everything there that may be. */
const WARM = 15;
/** Runs after that, if no hours are given. */
const RUNS = 16;
/** Parts after each of which hours of runs tell what the page holds. */
const PARTS = 24;
/** What may be there in the end more than after the first runs. */
const GROWTH = HOURS ? 1.05 : 1.1;
/** Starts by turns, so that not one run is repeated. */
const STARTS = ["plane", "circle", "random"];

describe("a long run", { timeout: HOURS * 2 * 3_600_000 + 1_800_000 }, () => {
  let browser, page, holdings;
  let runs = 0;
  before(async () => {
    browser = await open(renderer);
    page = new Page(browser.page);
    await countGraphics(browser.page);
    await page.visit(`${PAGE}?renderer=${renderer.query}&run=0&sample=none`);
    await page.page.waitForSelector("html[data-renderer]", { state: "attached" });
    await page.bring("long.obj", ellipsoid(LEVEL));
    holdings = await Holdings.of(browser.page);
  });
  after(() => browser?.close());

  /** One run from its start until it has converged. Gives its steps. */
  async function run() {
    await page.page.getByRole("combobox", { name: "Initial cut", exact: true }).selectOption(STARTS[runs % STARTS.length]);
    await page.pressAtOnce("Reset");
    await page.status(/^Ready/);
    await page.pressAtOnce("Run");
    const [, steps] = await page.status(/^Converged after (\d+) steps?/, 5 * PATIENCE_MS);
    await page.drawn();
    runs += 1;
    return Number(steps);
  }

  /** So many runs, or at least one and as many as take so many hours. Gives their steps. */
  async function go(count, hours = 0) {
    const end = performance.now() + hours * 3_600_000;
    let steps = 0;
    for (let i = 0; i < count || performance.now() < end; i += 1) steps += await run();
    return steps;
  }
  /** As many runs as asked for after the first, or a share of them. */
  async function goOn(share) {
    if (!HOURS) return go(share * RUNS);
    let steps = 0;
    for (let part = 0; part < share * PARTS; part += 1) {
      steps += await go(1, HOURS / PARTS);
      console.log(`after ${runs} runs: ${JSON.stringify(await holdings.measure())}`);
    }
    return steps;
  }

  it("holds in the end what it held after its first runs", async (t) => {
    let steps = await go(WARM);
    const first = await holdings.measure();
    if (HOURS) console.log(`after ${runs} runs: ${JSON.stringify(first)}`);
    steps += await goOn(0.5);
    let middle = await holdings.measure();
    steps += await goOn(0.5);
    let last = await holdings.measure();
    // The memory of a wasm module never shrinks: one frame that waited for a busy machine leaves it larger for good. What leaks grows on.
    const leaks = () => grown(first, last, GROWTH).filter((what) => grown(middle, last, 1 + (GROWTH - 1) / 2).includes(what));
    if (!HOURS && leaks().length) {
      middle = last;
      steps += await goOn(0.5);
      last = await holdings.measure();
    }
    t.diagnostic(`${runs} runs, ${steps} steps: ${JSON.stringify(first)}, ${JSON.stringify(last)}`);
    assert.ok(steps > 100 && last.graphics > 0, "something was done and is counted");
    assert.deepEqual(leaks().map((what) => `${what} from ${first[what]} to ${last[what]}`), []);
  });
});
