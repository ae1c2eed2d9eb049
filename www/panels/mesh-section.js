// The Mesh section on top of the parameters: what the mesh is, how large it really is, what is wrong with it, and what
// can be done to its triangles. Everything in it is told by the engine.

import { h, icon } from "../dom.js";
import { count, plural } from "../format.js";
import { recall, remember } from "../storage.js";
import { doctorPanel } from "./doctor.js";
import { health, healthBadge } from "./mesh.js";
import { preparePanel } from "./prepare.js";
import { sizePanel, sizeText } from "./size.js";

/** Whether the section is open, in the storage. */
const KEY = "mesh-section";

const known = (value) => (value === null || value === undefined ? "–" : count(value));

function factsOf(mesh) {
  const facts = [
    ["Components", known(mesh.components), "Parts that are not connected with each other"],
    ["Boundary loops", known(mesh.boundary_loops), "Closed curves along which the surface ends"],
    [
      "Genus",
      known(mesh.genus),
      mesh.genus === null ? "Handles are counted once the faces form an orientable surface" : "Handles, as of a cup or a ring",
    ],
    ["Euler number", known(mesh.euler), "Vertices − edges + faces"],
  ];
  if (mesh.triangles !== undefined && mesh.triangles !== mesh.faces) {
    facts.push(["Triangles", known(mesh.triangles), "What the faces with more than three corners are divided into"]);
  }
  if (mesh.format) facts.push(["Format", mesh.format, "What the mesh was read from"]);
  return facts;
}

/**
 * @param on `repair(id)`, `repairAll()`, `showFinding(id)`, `prepare(tool, values)`; `setUnit(id)` and
 * `setSize(axis, value)` resolve when the engine has answered
 */
export function meshSection(host, on) {
  const line = h("span", { class: "line" });
  const badge = h("span", { class: "state" });
  const summary = h("summary", {}, h("b", {}, "Mesh"), icon("down"), badge, line);
  const facts = h("dl", { class: "facts" });
  const notices = h("ul", { class: "notes", hidden: true });
  const size = sizePanel(on);
  const doctor = doctorPanel(on);
  const tools = preparePanel(on.prepare);
  const section = h(
    "details",
    { class: "mesh-section", "aria-label": "Mesh", role: "group", open: recall(KEY) === "open" },
    summary,
    h("div", { class: "set" }, facts, notices),
    size.node,
    doctor.node,
    tools.node,
  );
  host.replaceWith(section);
  section.hidden = true;
  // Only what a person does is remembered: the section also opens by itself.
  summary.addEventListener("click", () => remember(KEY, section.open ? "closed" : "open"));

  let mesh = null;
  let extent = "";
  let report = null;

  function summarise() {
    const faces = `${plural(mesh.vertices, "vertex", "vertices")} · ${plural(mesh.faces, "face")}`;
    line.replaceChildren(h("span", {}, faces), ...(extent ? [" ", h("span", {}, extent)] : []));
    // A mesh that is sound may still have been read with something passed over.
    const told = new Set(report?.findings.map(({ id }) => id));
    const rest = report ? (mesh.notices ?? []).filter(({ kind }) => !told.has(kind)) : (mesh.notices ?? []);
    notices.hidden = rest.length === 0;
    notices.replaceChildren(...rest.map(({ text }) => h("li", {}, text)));
  }

  return {
    /** Takes a `mesh` event; size and findings of the mesh before are gone. */
    show(event) {
      [mesh, extent, report] = [event, "", null];
      section.hidden = false;
      badge.replaceChildren();
      facts.replaceChildren(
        ...factsOf(event).map(([name, value, help]) => h("div", { title: help }, h("dt", {}, name), h("dd", {}, value))),
      );
      size.hide();
      doctor.hide();
      summarise();
    },
    /** Takes a `doctor` event: a mesh that cannot be cut as it is opens the section. */
    judge(event) {
      const isNew = report === null;
      report = event;
      badge.replaceChildren(healthBadge(health(event)));
      doctor.show(event);
      if (isNew && !event.solvable) {
        section.open = true;
        section.parentElement.scrollTop = 0;
      }
      if (mesh) summarise();
    },
    /** Takes a `size` event. */
    size(event) {
      extent = sizeText(event);
      size.show(event);
      if (mesh) summarise();
    },
    /** Takes a `tools` event. */
    tools: (event) => tools.show(event),
    /** While a preparation goes on, nothing else is begun. */
    busy(isBusy) {
      doctor.busy(isBusy);
      tools.busy(isBusy);
    },
    /** Opens the section and takes the focus there. */
    open() {
      section.open = true;
      summary.focus();
      section.scrollIntoView({ block: "start" });
    },
  };
}
