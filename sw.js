// Keeps the page on this computer, so that it opens without a network. Nothing here goes to another origin.
//
// Packed (`cargo xtask dist` fills in the two constants), all files but this one and the page are named after their
// contents, so that a page only ever finds files of its own version. The page itself is asked of the network first: a
// newer one is there with the next load, and the old cache goes when no tab needs it any more.
//
// Unpacked, everything is asked of the network first, and what it gave last is for when there is none.

const VERSION = "";
const FILES = [];

const PREFIX = "cutflow ";
/** One host may hold several copies of the page. */
const MINE = `${PREFIX}${registration.scope} `;
const CACHE = MINE + (VERSION || "unpacked");
const HOME = new URL("./", registration.scope).href;
/** How long a page waits for the network before the kept one is taken. */
const PATIENCE_MS = 3000;

const isPage = (url) => url.origin === location.origin && [HOME, `${HOME}index.html`].includes(url.origin + url.pathname);

addEventListener("install", (event) => {
  if (VERSION) event.waitUntil(keepAll());
  // Without versions there are none to mix.
  else skipWaiting();
});

addEventListener("activate", (event) => event.waitUntil(begin()));

addEventListener("fetch", (event) => {
  const { request } = event;
  const url = new URL(request.url);
  if (request.method !== "GET" || !url.href.startsWith(registration.scope)) return;
  if (request.mode === "navigate") {
    if (isPage(url)) event.respondWith(page(request));
  } else {
    event.respondWith(VERSION ? packed(request) : unpacked(request));
  }
});

// Unpacked, the page names what it loaded before this was there, and is told when all of it is kept.
addEventListener("message", (event) => {
  const { type, urls = [] } = event.data ?? {};
  if (type !== "keep") return;
  const kept = VERSION ? isKept() : Promise.all(urls.map((url) => keep(url))).then(() => true, () => false);
  event.waitUntil(kept.then((is) => event.ports[0]?.postMessage(is)));
});

/** All files of this version, the page last: a cache that has it is complete. */
async function keepAll() {
  const cache = await caches.open(CACHE);
  await cache.addAll(FILES.map((file) => new Request(file, { cache: "no-cache" })));
  const answer = await fetch(HOME, { cache: "no-store" });
  // In the middle of an upload the host may still have another page: then this is for later.
  if (!answer.ok || !(await answer.clone().text()).includes(VERSION)) throw new Error("the page on the host is of another version");
  await cache.put(HOME, answer);
}

async function isKept() {
  return (await (await caches.open(CACHE)).match(HOME)) !== undefined;
}

async function begin() {
  for (const name of await caches.keys()) {
    if (name.startsWith(MINE) && name !== CACHE) await caches.delete(name);
  }
  // The page that is open goes on with what it has; from now on its files come from here.
  await clients.claim();
}

async function page(request) {
  const late = new Promise((resolve) => setTimeout(resolve, PATIENCE_MS));
  const asked = fetch(request).then(async (answer) => {
    if (!VERSION && answer.ok) await put(HOME, answer.clone());
    return answer;
  });
  asked.catch(() => {});
  const first = await Promise.race([asked.catch(() => null), late]);
  if (first?.ok) return first;
  return (await newest()) ?? first ?? asked;
}

/** The page of the newest cache that is complete. */
async function newest() {
  for (const name of (await caches.keys()).reverse()) {
    if (!name.startsWith(MINE)) continue;
    const found = await (await caches.open(name)).match(HOME);
    if (found) return found;
  }
  return undefined;
}

async function packed(request) {
  return (await caches.match(request, { ignoreSearch: true })) ?? fetch(request);
}

async function unpacked(request) {
  try {
    const answer = await fetch(request);
    if (answer.ok) await put(request, answer.clone());
    return answer;
  } catch (error) {
    const found = await (await caches.open(CACHE)).match(request, { ignoreSearch: true });
    if (found) return found;
    throw error;
  }
}

async function keep(url) {
  const isMine = url.startsWith(registration.scope);
  const answer = isMine && (await fetch(url));
  if (answer?.ok) await put(isPage(new URL(url)) ? HOME : url, answer);
}

/** Storage may be full or forbidden: the page does without. */
async function put(key, answer) {
  try {
    await (await caches.open(CACHE)).put(key, answer);
  } catch {
    // See above.
  }
}
