// The numbers of the pieces: text over the canvas, at a constant size.

import { s } from "./dom.js";

/** Letters and their rim, which keeps them apart from whatever texture is under them. */
const [INK, RIM, RIM_PX] = ["#1b1d22", "#ffffffe6", 4];

/** The numbers in `host`. Anchors are `x, y` in pixels and a third number for each piece; x is no number where it is out of sight. */
export function pieceNumbers(host) {
  const layer = s("svg", { class: "numbers", "aria-hidden": "true" });
  const texts = [];
  host.append(layer);

  return {
    show(anchors) {
      const wanted = anchors.length / 3;
      while (texts.length < wanted) {
        const text = s("text", {}, String(texts.length + 1));
        texts.push(text);
        layer.append(text);
      }
      while (texts.length > wanted) texts.pop().remove();
      texts.forEach((text, i) => {
        const x = anchors[3 * i];
        const isShown = Number.isFinite(x);
        text.toggleAttribute("hidden", !isShown);
        if (isShown) text.setAttribute("transform", `translate(${x.toFixed(1)} ${anchors[3 * i + 1].toFixed(1)})`);
      });
    },
    /** Draws them on a copy of the view. */
    write(context, anchors) {
      context.font = "600 11px system-ui, sans-serif";
      context.textAlign = "center";
      context.textBaseline = "middle";
      context.lineJoin = "round";
      [context.fillStyle, context.strokeStyle, context.lineWidth] = [INK, RIM, RIM_PX];
      for (let i = 0; 3 * i < anchors.length; i += 1) {
        const [x, y] = [anchors[3 * i], anchors[3 * i + 1]];
        if (!Number.isFinite(x)) continue;
        context.strokeText(String(i + 1), x, y);
        context.fillText(String(i + 1), x, y);
      }
    },
  };
}
