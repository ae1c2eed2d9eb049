// What is said of the place under the pointer, beside it.

import { h } from "./dom.js";

export function viewTip() {
  const tip = h("p", { class: "tip", "aria-hidden": "true", hidden: true });
  return {
    /** Says nodes at a place of a view; nothing without any. */
    show(host, at, nodes) {
      tip.hidden = nodes.length === 0;
      if (tip.hidden) return;
      if (tip.parentElement !== host) host.append(tip);
      tip.replaceChildren(...nodes);
      // Beside the pointer, on the side where there is room.
      const isLeft = at.x > host.clientWidth / 2;
      const isAbove = at.y > host.clientHeight / 2;
      tip.style.translate = `${isLeft ? "calc(-100% - 14px)" : "14px"} ${isAbove ? "calc(-100% - 10px)" : "14px"}`;
      tip.style.left = `${at.x}px`;
      tip.style.top = `${at.y}px`;
    },
    hide: () => (tip.hidden = true),
  };
}
