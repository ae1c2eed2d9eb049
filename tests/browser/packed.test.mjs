// `cargo xtask dist` makes a folder that works from any path of any static host.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { COARSE, PACKED_PAGE, RENDERERS, open } from "./chromium.mjs";
import { Page } from "./page.mjs";

describe("packed for a host", { timeout: 300_000 }, () => {
  let browser;
  before(async () => {
    browser = await open(RENDERERS[0], COARSE);
  });
  after(() => browser?.close());

  it("runs from a folder deep inside a site, and asks for nothing outside it", async () => {
    const asked = [];
    browser.page.on("request", (request) => asked.push(request.url()));
    const page = new Page(browser.page);
    await page.visit(PACKED_PAGE);
    await page.status(/^(Running step [1-9]|Converged)/);
    const outside = asked.filter((url) => !url.startsWith(PACKED_PAGE) && !/^(blob|data):/.test(url));
    assert.deepEqual(outside, []);
    assert.deepEqual(browser.troubles, []);
  });
});
