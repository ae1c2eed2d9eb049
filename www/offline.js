// The page on this computer: registers the service worker that opens it without a network.

/** Packed pages lie in a folder that is named after its contents. */
const IS_PACKED = /\/cutflow-[0-9a-f]{16}\//.test(import.meta.url);
const HERE = ["localhost", "127.0.0.1", "[::1]"];

/** What the worker loads by itself, and what it is started from. */
const ENGINE = ["./worker.js", "./pkg/engine.js", "./pkg/engine_bg.wasm"];

/**
 * Keeps the page for later, once nothing more urgent is to be loaded. While the page is worked on (unpacked, on this very
 * machine) only where `?offline=1` asks for it: nobody shall look at files of yesterday.
 */
export async function keepOffline() {
  const { serviceWorker } = navigator;
  const isAsked = new URLSearchParams(location.search).get("offline") === "1";
  if (!serviceWorker || (!IS_PACKED && HERE.includes(location.hostname) && !isAsked)) return;
  try {
    await serviceWorker.register("sw.js", { updateViaCache: "none" });
    const { active } = await serviceWorker.ready;
    const loaded = performance.getEntriesByType("resource").map(({ name }) => name);
    const engine = ENGINE.map((file) => new URL(file, import.meta.url).href);
    const urls = [...new Set([location.href.split("#")[0], ...loaded, ...engine])];
    const answers = new MessageChannel();
    answers.port1.onmessage = ({ data: isKept }) => {
      if (isKept) document.documentElement.dataset.offline = "";
      answers.port1.close();
    };
    active.postMessage({ type: "keep", urls }, [answers.port2]);
  } catch {
    // Private windows, embedded pages and odd hosts: the page then needs its network, as before.
  }
}
