// Steps upon steps in one page: hours of them hold what minutes hold. Some hundred on a small mesh; with CUTFLOW_HOURS in the
// environment (`cargo xtask soak --only browser`) so many hours of them on 20 480 triangles.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { PAGE, RENDERERS, open } from "./chromium.mjs";
import { Holdings, countGraphics, grown } from "./holdings.mjs";
import { ellipsoid } from "./meshes.mjs";
import { Page } from "./page.mjs";

const [renderer] = RENDERERS;
const HOURS = Number(process.env.CUTFLOW_HOURS ?? 0);
/** Without hours the time is compressed: so many steps, of a mesh with so many times fewer triangles. */
const STEPS = 800;
const LEVEL = HOURS ? 5 : 3;
/** What may be there in the end more than after the first tenth. */
const GROWTH = HOURS ? 1.05 : 1.1;
/** Starts by turns, so that not one run is repeated. */
const STARTS = ["plane", "circle", "random"];

describe("a long run", { timeout: HOURS * 1.5 * 3_600_000 + 600_000 }, () => {
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

  /** Runs until a share of the whole is done. Gives the steps. */
  async function go(share) {
    const end = performance.now() + share * HOURS * 3_600_000;
    let steps = 0;
    while (HOURS ? performance.now() < end : steps < share * STEPS) steps += await run();
    return steps;
  }

  it("holds in the end what it held after its first tenth", async (t) => {
    let steps = await go(0.1);
    const first = await holdings.measure();
    steps += await go(0.9);
    let last = await holdings.measure();
    t.diagnostic(`${runs} runs, ${steps} steps: ${JSON.stringify(first)}, ${JSON.stringify(last)}`);
    let more = grown(first, last, GROWTH);
    if (more.length) {
      // The memory of a wasm module never shrinks: one frame that waited for a busy machine leaves it larger for good. What leaks
      // grows on.
      const before = last;
      await go(0.5);
      last = await holdings.measure();
      const again = grown(before, last, 1 + (GROWTH - 1) / 2);
      more = more.filter((what) => again.includes(what));
    }
    assert.deepEqual(more.map((what) => `${what} from ${first[what]} to ${last[what]}`), []);
  });
});
