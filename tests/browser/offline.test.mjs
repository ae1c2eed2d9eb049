// The page without a network: packed for a host, and as it lies in its folder. And what it asks of the network at all.

import assert from "node:assert/strict";
import { createServer } from "node:http";
import { after, before, describe, it } from "node:test";

import { COARSE, PACKED_PAGE, PAGE, PATIENCE_MS, RENDERERS, open } from "./chromium.mjs";
import { Page } from "./page.mjs";

const [WEBGL] = RENDERERS;
/** Names a version of the packed page. */
const VERSION = /cutflow-[0-9a-f]{16}/;
const OTHER = "cutflow-00000000deadbeef";

describe("offline", { timeout: 600_000 }, () => {
  let browser;
  const contexts = [];
  before(async () => (browser = await open(WEBGL)));
  after(() => browser?.close());

  /** A new visitor with one page; `asked` fills with every address that page, workers and service worker ask for. */
  async function visitor() {
    const context = await browser.page.context().browser().newContext({ viewport: { width: 1280, height: 800 }, deviceScaleFactor: COARSE, reducedMotion: "reduce" });
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
  const cacheNames = (page) => page.page.evaluate(() => caches.keys());

  for (const [name, url] of [["packed for a host", PACKED_PAGE], ["as it lies in its folder", PAGE]]) {
    // While the page is worked on, only who asks for it has it kept.
    const query = url === PACKED_PAGE ? "" : "&offline=1";
    const home = new URL(".", url).href;

    it(`${name}, it opens again without a network and cuts`, async () => {
      const page = await visitor();
      await page.visit(`${url}?renderer=webgl&run=0&sample=none${query}`);
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
    await page.visit(`${PACKED_PAGE}?renderer=webgl&run=0&sample=none`);
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
    await page.visit(`${PAGE}?renderer=webgl&run=0&sample=none`);
    assert.deepEqual(await page.page.evaluate(async () => (await navigator.serviceWorker.getRegistrations()).length), 0);
  });

  it("takes a new version with the next load, whole, and drops the old one", async () => {
    const page = await visitor();
    const host = await uploads();
    try {
      const url = `${host.url}?renderer=webgl&run=0&sample=none`;
      await page.visit(url);
      await isKept(page);
      await isControlled(page);
      const [old] = VERSION.exec(await version(page));
      assert.equal((await cacheNames(page)).length, 1);

      host.upload(old);
      await page.visit(url);
      const now = await version(page);
      assert.ok(now.includes(OTHER) && !now.includes(old), "the next load is the new version, and nothing else");
      await page.until("both are kept while the old one may be in use", () => cacheNames(page), (names) => names.length === 2);
      // The new service worker waits until no tab is left, and takes over then.
      await page.page.waitForFunction(async () => (await navigator.serviceWorker.getRegistration()).waiting !== null);
      // It may need a moment that a person leaves it and this does not.
      await page.until("the old one is gone", async () => {
        await page.page.goto("about:blank");
        await page.page.waitForTimeout(1000);
        await page.visit(url);
        return cacheNames(page);
      }, (names) => names.length === 1 && names[0].endsWith(OTHER));
      host.end();
      await page.context.setOffline(true);
      await page.visit(url);
      assert.ok((await version(page)).includes(OTHER));
      assert.deepEqual(page.troubles, []);
    } finally {
      host.end();
    }
  });
});

/** A host that shows the packed page, and after `upload(old)` the same files under another version. */
async function uploads() {
  let old = null;
  const server = createServer((request, response) => {
    const path = request.url.slice(1);
    if (old !== null && path.includes(old)) return response.writeHead(404).end();
    // A page that has gone asks no more: what was on its way is dropped.
    answer(path, response).catch(() => response.destroy());
  });
  async function answer(path, response) {
    const found = await fetch(new URL(old === null ? path : path.replaceAll(OTHER, old), PACKED_PAGE));
    let body = Buffer.from(await found.arrayBuffer());
    // What names the version are the page and its service worker.
    if (old !== null && !VERSION.test(path)) body = Buffer.from(body.toString("utf8").replaceAll(old, OTHER));
    response.writeHead(found.status, { "content-type": found.headers.get("content-type"), "cache-control": "no-store" }).end(body);
  }
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return {
    url: `http://127.0.0.1:${server.address().port}/`,
    upload: (version) => (old = version),
    end() {
      server.close();
      server.closeAllConnections();
    },
  };
}
