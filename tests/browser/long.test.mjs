// Steps upon steps in one page: hours of them hold what minutes hold. Some hundreds on a small mesh; with CUTFLOW_HOURS in the
// environment (`cargo xtask soak`) so many hours of them on 20 480 triangles.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { PAGE, RENDERERS, open } from "./chromium.mjs";
import { Holdings, countGraphics, grown } from "./holdings.mjs";
import { ellipsoid } from "./meshes.mjs";
import { Page } from "./page.mjs";

const [renderer] = RENDERERS;
const HOURS = Number(process.env.CUTFLOW_HOURS ?? 0);
const LEVEL = HOURS ? 5 : 3;
/** Undo goes back 40 changes, of which a run takes three: only then is everything there that may be. */
const WARM = 15;
/** Runs after that, if no hours are given. */
const RUNS = 15;
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
    const [, steps] = await page.status(/^Converged after (\d+) steps?/);
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
  const goOn = (share) => (HOURS ? go(1, share * HOURS) : go(share * RUNS));

  it("holds in the end what it held after its first runs", async (t) => {
    let steps = await go(WARM);
    const first = await holdings.measure();
    steps += await goOn(1);
    let last = await holdings.measure();
    t.diagnostic(`${runs} runs, ${steps} steps: ${JSON.stringify(first)}, ${JSON.stringify(last)}`);
    assert.ok(steps > 100 && last.graphics > 0, "something was done and is counted");
    let more = grown(first, last, GROWTH);
    if (more.length) {
      // The memory of a wasm module never shrinks: one frame that waited for a busy machine leaves it larger for good. What leaks
      // grows on.
      const before = last;
      await goOn(0.5);
      last = await holdings.measure();
      const again = grown(before, last, 1 + (GROWTH - 1) / 2);
      more = more.filter((what) => again.includes(what));
    }
    assert.deepEqual(more.map((what) => `${what} from ${first[what]} to ${last[what]}`), []);
  });
});
