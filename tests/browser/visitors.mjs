// Visitors of their own in one browser: each with an empty storage, each with as many tabs as a test asks for.

import { after, before } from "node:test";

import { COARSE, PATIENCE_MS, RENDERERS, open } from "./chromium.mjs";
import { Page } from "./page.mjs";

/** To be called within `describe`: `visitor(options, script)` gives a context, `tab(context)` a page in it, `leave()` ends all. */
export function visitors() {
  let browser;
  const contexts = [];
  before(async () => (browser = await open(RENDERERS[0])));
  after(() => browser?.close());
  return {
    /** A new visitor, whose pages run `script` first. */
    async visitor(options = {}, script = null) {
      const context = await browser.page.context().browser().newContext({ viewport: { width: 1280, height: 800 }, deviceScaleFactor: COARSE, reducedMotion: "reduce", colorScheme: "light", ...options });
      contexts.push(context);
      if (script) await context.addInitScript(script);
      return context;
    },
    /** A page; its `troubles` fills with errors of the page itself. */
    async tab(context) {
      const page = await context.newPage();
      page.setDefaultTimeout(PATIENCE_MS);
      const troubles = [];
      page.on("pageerror", (error) => troubles.push(error.stack ?? String(error)));
      return Object.assign(new Page(page), { troubles });
    },
    async leave() {
      for (const context of contexts.splice(0)) await context.close();
    },
  };
}

/** The sessions that the browser keeps: `{ name, about, size }`. */
export const records = (page) =>
  page.page.evaluate(
    () =>
      new Promise((resolve) => {
        const request = indexedDB.open("cutflow", 1);
        request.onupgradeneeded = () => request.result.createObjectStore("sessions", { keyPath: "key" });
        request.onsuccess = () => {
          const all = request.result.transaction("sessions").objectStore("sessions").getAll();
          all.onsuccess = () => {
            request.result.close();
            resolve(all.result.map(({ name, about, bytes }) => ({ name, about, size: bytes.length })));
          };
        };
      }),
  );
