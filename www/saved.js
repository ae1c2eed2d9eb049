// Sessions kept on this computer, one record for each tab that had one: a project file, its name and when it was kept.
//
// Storage may be denied, full or broken at any time: whoever calls is told by `Refused`, whose message says which.

const [DATABASE, STORE] = ["cutflow", "sessions"];
/** Older sessions than this many are dropped. */
const MOST = 3;
/** The lock that a tab holds while its session goes on. */
const lockOf = (key) => `cutflow session ${key}`;

export class Refused extends Error {
  /** @param why `denied` or `full` */
  constructor(why, cause) {
    super(why, { cause });
    this.why = why;
  }
}

const refused = (error) => new Refused(error?.name === "QuotaExceededError" ? "full" : "denied", error);

function opened() {
  return new Promise((resolve, reject) => {
    // Where storage is denied the name itself may throw.
    const request = indexedDB.open(DATABASE, 1);
    request.onupgradeneeded = () => request.result.createObjectStore(STORE, { keyPath: "key" });
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
    request.onblocked = () => reject(new Error("another tab holds an older store"));
  });
}

/** Does `work(store)` in one transaction; gives the result of the request that it returns, once all is written. */
async function inStore(mode, work) {
  let database = null;
  try {
    database = await opened();
    return await new Promise((resolve, reject) => {
      const transaction = database.transaction(STORE, mode, { durability: "relaxed" });
      const request = work(transaction.objectStore(STORE));
      transaction.oncomplete = () => resolve(request?.result);
      transaction.onabort = () => reject(transaction.error ?? request?.error);
      transaction.onerror = () => reject(transaction.error ?? request?.error);
    });
  } catch (error) {
    throw refused(error);
  } finally {
    database?.close();
  }
}

/** Keeps `{ key, name, when, about, bytes }`, in place of what the key had. */
export async function keepSession(record) {
  await inStore("readwrite", (store) => store.put(record));
  const all = await sessions();
  const old = all.filter(({ key }) => key !== record.key).slice(MOST - 1);
  for (const { key } of old) await dropSession(key);
}

export function dropSession(key) {
  return inStore("readwrite", (store) => store.delete(key));
}

/** All of them, newest first. */
async function sessions() {
  const all = await inStore("readonly", (store) => store.getAll());
  return all.filter(({ when }) => Number.isFinite(when)).sort((a, b) => b.when - a.when);
}

/** The newest one that belongs to no open tab, null for none. */
export async function lastSession() {
  let held = [];
  try {
    held = (await navigator.locks.query()).held.map(({ name }) => name);
  } catch {
    // No locks, no knowledge of other tabs.
  }
  return (await sessions()).find(({ key }) => !held.includes(lockOf(key))) ?? null;
}

/** Tells other tabs that this session goes on, as long as the page does. */
export function holdSession(key) {
  try {
    navigator.locks.request(lockOf(key), () => new Promise(() => {})).catch(() => {});
  } catch {
    // See above.
  }
}
