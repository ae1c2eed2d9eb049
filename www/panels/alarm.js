// The one warning that stands over the charts: a pattern with turned triangles or overlaps must not be cut.

import { h, icon } from "../dom.js";
import { plural } from "../format.js";

/** A running flow has a bad step now and then: what lasts shorter than this is not told, nor taken back. */
const LASTING_MS = 600;

/**
 * @param host a live region
 * @param on `reveal(ids, patch)` shows rows of the measures and a piece, -1 for none in particular; `isMoving()` tells
 * whether the cut is on its way
 */
export function alarm(host, { reveal, isMoving }) {
  let wanted = null;
  let shown = "";
  let timer = 0;

  function apply() {
    clearTimeout(timer);
    timer = 0;
    const text = wanted?.text ?? "";
    if (text === shown) return;
    shown = text;
    if (text === "") {
      host.replaceChildren();
      return;
    }
    // What the click shows is what is known by then.
    const show = () => wanted && reveal(wanted.ids, wanted.patch);
    const button = host.querySelector("button") ?? h("button", { title: "Show it in Measures", onclick: show }, icon("alert"), h("span"), h("b", {}, "Show"));
    button.querySelector("span").textContent = text;
    if (!button.isConnected) host.append(button);
  }

  return {
    /** Takes the rows and the pieces of a `measures` event; empty lists where there is nothing to cut. */
    show(rows, pieces) {
      const count = (id) => rows.find((row) => row.id === id)?.now ?? pieces.reduce((sum, piece) => sum + (piece[id] ?? 0), 0);
      const [flipped, overlaps] = [count("flipped"), count("overlaps")];
      const parts = [
        flipped > 0 ? `${plural(flipped, "triangle")} turned over` : null,
        overlaps > 0 ? plural(overlaps, "overlap") : null,
      ].filter(Boolean);
      const bad = pieces.filter((piece) => piece.flipped > 0 || piece.overlaps > 0);
      const place = bad.length === 1 && pieces.length > 1 ? ` in piece ${bad[0].patch + 1}` : "";
      wanted = parts.length === 0 ? null : {
        text: `${parts.join(", ")}${place}: not safe to cut yet`,
        ids: [flipped > 0 && "flipped", overlaps > 0 && "overlaps"].filter(Boolean),
        patch: bad[0]?.patch ?? -1,
      };
      if (!isMoving()) apply();
      else if (!timer) timer = setTimeout(apply, LASTING_MS);
    },
  };
}
