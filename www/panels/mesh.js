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
  const [name, facts] = [h("b"), h("span")];
  const button = h("button", { class: "link" });
  const list = h("div", { class: "pop list", role: "group", "aria-label": "Notices", hidden: true });
  const menu = h("span", { class: "menu", hidden: true }, button, list);
  byId("mesh").append(name, facts, menu);
  const { show } = popover(button, list);

  return {
    /** Takes a `mesh` event. */
    show(mesh) {
      const { vertices, faces, notices } = mesh;
      name.textContent = mesh.name;
      facts.textContent = `${plural(vertices, "vertex", "vertices")} · ${plural(faces, "face")} · ${shape(mesh)}`;
      name.title = `${mesh.name}: ${facts.textContent}`;
      show(false);
      menu.hidden = false;
      button.textContent = notices.length === 0 ? "No issues found" : plural(notices.length, "notice");
      list.replaceChildren(
        notices.length === 0
          ? h("p", {}, "Indices, coordinates, edges and orientation were checked; nothing had to be repaired.")
          : h("ul", {}, ...notices.map((notice) => h("li", {}, notice.text))),
      );
    },
  };
}
