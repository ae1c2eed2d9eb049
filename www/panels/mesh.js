// Which mesh is open and what was noticed about it.

import { byId, h, popover } from "../dom.js";
import { count, plural } from "../format.js";

function shape({ components, boundary_loops, genus }) {
  const parts = [];
  if (components > 1) parts.push(plural(components, "component"));
  parts.push(boundary_loops > 0 ? plural(boundary_loops, "boundary loop") : "closed");
  parts.push(`genus ${count(genus)}`);
  return parts.join(", ");
}

export function meshLine() {
  const host = byId("mesh");
  return {
    /** Takes a `mesh` event. */
    show(mesh) {
      const { name, vertices, faces, notices } = mesh;
      const isClean = notices.length === 0;
      const button = h("button", { class: "link" }, isClean ? "No issues found" : plural(notices.length, "notice"));
      const list = h(
        "div",
        { class: "pop list", role: "group", "aria-label": "Notices", hidden: true },
        ...(isClean
          ? [h("p", {}, "Indices, coordinates, edges and orientation were checked; nothing had to be repaired.")]
          : [h("ul", {}, ...notices.map((notice) => h("li", {}, notice.text)))]),
      );
      const facts = `${plural(vertices, "vertex", "vertices")} · ${plural(faces, "face")} · ${shape(mesh)}`;
      host.replaceChildren(
        h("b", { title: `${name}: ${facts}` }, name),
        h("span", {}, facts),
        h("span", { class: "menu" }, button, list),
      );
      popover(button, list);
    },
  };
}
