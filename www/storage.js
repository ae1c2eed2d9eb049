// What the page remembers on this computer between visits.

const PREFIX = "cutflow.";

/** The text kept under a name, null where there is none. */
export function recall(name) {
  try {
    return localStorage.getItem(PREFIX + name);
  } catch {
    // Private windows and embedded pages may have no storage; a choice then lasts as long as the page.
    return null;
  }
}

/** Keeps a text; null forgets it. */
export function remember(name, text) {
  try {
    if (text === null) localStorage.removeItem(PREFIX + name);
    else localStorage.setItem(PREFIX + name, text);
  } catch {
    // See above.
  }
}
