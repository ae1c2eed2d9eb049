// The offer to go on where the last visit ended: a strip at the foot of the views, beside the sample that runs meanwhile.

import { h, icon } from "../dom.js";
import { Refused, dropSession, lastSession } from "../saved.js";

const MINUTE = 60_000;
const UNITS = [
  ["minute", MINUTE, 60],
  ["hour", 60 * MINUTE, 24],
  ["day", 24 * 60 * MINUTE, Infinity],
];

/** How long ago, in words. */
function ago(when) {
  const words = new Intl.RelativeTimeFormat("en", { numeric: "auto" });
  for (const [unit, length, most] of UNITS) {
    const count = Math.round((Date.now() - when) / length);
    if (count < most) return count < 1 && unit === "minute" ? "just now" : words.format(-count, unit);
  }
  return "";
}

/**
 * Offers the last session, if there is one.
 *
 * @param on `open(name, bytes)` opens a project and says whether that worked, `say(sentence)`
 */
export async function offerRestore(on) {
  let strip = null;
  const end = () => strip?.remove();

  async function restore({ key, name, bytes }) {
    end();
    const isRead = bytes?.length > 0 && (await on.open(`${name} (last session)`, bytes));
    if (!isRead) on.say("The last session could not be read and was dropped.");
    await forget(key);
  }

  async function forget(key) {
    end();
    try {
      await dropSession(key);
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
    }
  }

  let record = null;
  try {
    record = await lastSession();
  } catch (error) {
    // Where nothing can be kept there is nothing to offer.
    if (!(error instanceof Refused)) throw error;
  }
  if (!record) return { end };
  const { name, when, about } = record;
  strip = h(
    "div",
    { class: "restore", role: "group", "aria-label": "Last session" },
    h("p", {}, h("b", {}, name), ` ${[about, ago(when)].filter(Boolean).join(", ")}`),
    h("button", { class: "btn primary", onclick: () => restore(record) }, "Restore last session"),
    h("button", { class: "icon", "aria-label": "Forget last session", title: "Forget last session", onclick: () => forget(record.key) }, icon("close")),
  );
  document.querySelector(".notices").after(strip);
  return { end };
}
