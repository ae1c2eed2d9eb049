// Which mesh is open and whether it is sound: the short line in the header.

import { byId, h, icon, write } from "../dom.js";
import { count, plural } from "../format.js";

/**
 * How a mesh does, from a `doctor` event: `{ id, icon, text }`, the id being `healthy`, `findings` or `blocked`. Notes
 * are facts and leave a mesh healthy.
 */
export function health({ solvable, findings }) {
  if (!solvable) return { id: "blocked", icon: "block", text: "needs repair" };
  const grave = findings.filter(({ severity }) => severity !== "note").length;
  if (grave === 0) return { id: "healthy", icon: "check", text: "healthy" };
  return { id: "findings", icon: "alert", text: plural(grave, "finding") };
}

/** The state with its icon, in a colour that only repeats what the icon says. */
export const healthBadge = ({ id, icon: shape, text }) =>
  h("span", { class: `health ${id}` }, icon(shape), h("span", {}, text));

/** `open()` shows the whole report. */
export function meshLine(open) {
  const [name, facts] = [h("b"), h("span")];
  const title = "Size, repairs and preparation of the mesh";
  const button = h("button", { class: "link", title, hidden: true, onclick: open });
  byId("mesh").append(name, facts, button);

  return {
    /** Takes a `mesh` event; the engine's verdict follows. */
    show(mesh) {
      write(name, mesh.name);
      write(facts, `${plural(mesh.vertices, "vertex", "vertices")} · ${plural(mesh.faces, "face")}`);
      name.title = `${mesh.name}: ${count(mesh.vertices)} vertices, ${count(mesh.faces)} faces`;
      button.hidden = true;
    },
    /** Takes a `doctor` event. */
    judge(report) {
      button.replaceChildren(healthBadge(health(report)));
      button.hidden = false;
    },
  };
}
