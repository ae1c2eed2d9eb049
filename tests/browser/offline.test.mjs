// The page without a network: packed for a host, and as it lies in its folder. And what it asks of the network at all.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { PACKED_PAGE, PAGE, PATIENCE_MS, RENDERERS, open } from "./chromium.mjs";
import { Page } from "./page.mjs";

const [WEBGL] = RENDERERS;
/** Names a version of the packed page. */
const VERSION = /cutflow-[0-9a-f]{16}/;

describe("offline", { timeout: 600_000 }, () => {
  let browser;
  const contexts = [];
  before(async () => (browser = await open(WEBGL)));
  after(() => browser?.close());

  /** A new visitor with one page; `asked` fills with every address that page, workers and service worker ask for. */
  async function visitor() {
    const context = await browser.page.context().browser().newContext({ viewport: { width: 1280, height: 800 }, reducedMotion: "reduce" });
    contexts.push(context);
    const page = await context.newPage();
    page.setDefaultTimeout(PATIENCE_MS);
    const [asked, troubles] = [[], []];
    context.on("request", (request) => asked.push(request.url()));
    page.on("pageerror", (error) => troubles.push(error.stack ?? String(error)));
    return Object.assign(new Page(page), { context, asked, troubles });
  }
  const isKept = (page) => page.page.waitForSelector("html[data-offline]", { state: "attached" });
  const isControlled = (page) => page.page.waitForFunction(() => navigator.serviceWorker.controller !== null);
  const version = (page) => page.page.evaluate(() => [...document.scripts].map(({ src }) => src).join(" "));
  const caches_ = (page) => page.page.evaluate(() => caches.keys());

  for (const [name, url] of [["packed for a host", PACKED_PAGE], ["as it lies in its folder", PAGE]]) {
    // While the page is worked on, only who asks for it has it kept.
    const query = url === PACKED_PAGE ? "" : "&offline=1";
    const home = new URL(".", url).href;

    it(`${name}, it opens again without a network and cuts`, async () => {
      const page = await visitor();
      await page.visit(`${url}?renderer=webgl&run=0${query}`);
      await isKept(page);
      await isControlled(page);
      await page.context.setOffline(true);
      // Another address of the same page.
      await page.visit(`${url}?renderer=webgl&run=0&sample=ball`);
      await page.press("Step");
      await page.status(/^Paused at step 1$/);
      await page.page.waitForSelector("html[data-renderer]", { state: "attached" });
      assert.deepEqual(page.troubles, []);
      const outside = page.asked.filter((address) => !address.startsWith(home) && !/^(blob|data):/.test(address));
      assert.deepEqual(outside, [], "no request leaves the folder of the page");
    });
  }

  it("is installable: a manifest with icons that exist", async () => {
    const page = await visitor();
    await page.visit(`${PACKED_PAGE}?renderer=webgl&run=0`);
    const link = await page.page.locator("link[rel=manifest]").evaluate(({ href }) => href);
    const manifest = await page.page.evaluate(async (link) => (await fetch(link)).json(), link);
    assert.equal(manifest.display, "standalone");
    assert.equal(new URL(manifest.start_url, link).href, new URL(".", PACKED_PAGE).href);
    for (const { src, sizes } of manifest.icons) {
      const size = await page.page.evaluate(async (src) => {
        const image = new Image();
        image.src = src;
        await image.decode();
        return `${image.naturalWidth}x${image.naturalHeight}`;
      }, new URL(src, link).href);
      if (sizes !== "any") assert.equal(size, sizes, src);
    }
    // What the browser itself finds missing.
    const session = await page.context.newCDPSession(page.page);
    const { installabilityErrors } = await session.send("Page.getInstallabilityErrors");
    assert.deepEqual(installabilityErrors.filter(({ errorId }) => errorId !== "in-incognito"), []);
  });

  it("is not kept on this machine while the page is worked on", async () => {
    const page = await visitor();
    await page.visit(`${PAGE}?renderer=webgl&run=0`);
    assert.deepEqual(await page.page.evaluate(async () => (await navigator.serviceWorker.getRegistrations()).length), 0);
  });

  it("takes a new version with the next load, whole, and drops the old one", async () => {
    const page = await visitor();
    const other = "cutflow-00000000deadbeef";
    let isNew = false;
    // The host as it is after an upload: another page, another worker, the same files under another name.
    await page.context.route(`${PACKED_PAGE}**`, async (route) => {
      const address = route.request().url();
      if (!isNew) return route.continue();
      const answer = await route.fetch({ url: address.replaceAll(other, page.old) });
      const type = answer.headers()["content-type"] ?? "";
      const isText = address.split("?")[0] === PACKED_PAGE || /sw\.js|index\.html/.test(address);
      if (VERSION.test(address) && !address.includes(other)) return route.fulfill({ status: 404, body: "gone" });
      if (!isText) return route.fulfill({ response: answer });
      const body = (await answer.text()).replaceAll(page.old, other);
      return route.fulfill({ status: 200, contentType: type, body });
    });
    await page.visit(`${PACKED_PAGE}?renderer=webgl&run=0`);
    await isKept(page);
    await isControlled(page);
    [page.old] = VERSION.exec(await version(page));
    assert.equal((await caches_(page)).length, 1);

    isNew = true;
    await page.visit(`${PACKED_PAGE}?renderer=webgl&run=0`);
    const now = await version(page);
    assert.ok(now.includes(other) && !now.includes(page.old), "the next load is the new version, and nothing else");
    await page.until("both are kept while the old one may be in use", () => caches_(page), (names) => names.length === 2);
    // The new worker has to be waiting before the tab is left, and to take over after that.
    await page.page.waitForFunction(async () => (await navigator.serviceWorker.getRegistration()).waiting !== null);
    await page.page.goto("about:blank");
    await page.visit(`${PACKED_PAGE}?renderer=webgl&run=0`);
    await page.until("the old one is gone", () => caches_(page), (names) => names.length === 1 && names[0].endsWith(other));
    await page.context.setOffline(true);
    await page.visit(`${PACKED_PAGE}?renderer=webgl&run=0`);
    assert.ok((await version(page)).includes(other));
    assert.deepEqual(page.troubles, []);
  });
});
