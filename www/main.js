// Wires the page together: the engine's events go to the panels, what people do goes to the engine as commands. The
// page itself holds no geometry; it draws, each animation frame, the newest scene that the worker has sent.

import { autosave } from "./autosave.js";
import { coneMethod } from "./cones.js";
import { byId, h, paced, settle } from "./dom.js";
import { EngineClient } from "./engine-client.js";
import { listenToKeys } from "./keys.js";
import { keepOffline } from "./offline.js";
import { FLAT, SURFACE, Views } from "./views.js";
import { alarm } from "./panels/alarm.js";
import { brushPanel } from "./panels/brush.js";
import { comparePanel } from "./panels/compare.js";
import { descriptions } from "./panels/describe.js";
import { fileSources } from "./panels/drop.js";
import { embed } from "./panels/embed.js";
import { emptyState } from "./panels/empty.js";
import { errorPanel, toast } from "./panels/error.js";
import { download, exportMenu } from "./panels/export-menu.js";
import { historyPanel } from "./panels/history.js";
import { keepCut } from "./panels/keep.js";
import { keyboardHelp } from "./panels/keyboard.js";
import { learnPanel } from "./panels/learn.js";
import { legends } from "./panels/legends.js";
import { measuresPanel } from "./panels/measures.js";
import { meshLine } from "./panels/mesh.js";
import { meshSection } from "./panels/mesh-section.js";
import { parametersPanel } from "./panels/parameters.js";
import { patternPanel } from "./panels/pattern.js";
import { piecesPanel } from "./panels/pieces.js";
import { energyPlot } from "./panels/plot.js";
import { presetsPanel } from "./panels/presets.js";
import { offerRestore } from "./panels/restore.js";
import { ruler } from "./panels/ruler.js";
import { address, readAddress, shareButton, valueFor } from "./panels/share.js";
import { splitters } from "./panels/splitters.js";
import { statusPanel } from "./panels/status.js";
import { symmetryPanel } from "./panels/symmetry.js";
import { textureTool } from "./panels/texture.js";
import { theme } from "./panels/theme.js";
import { methodTabs, sheetTabs } from "./panels/tabs.js";
import { hasValues, lengthOf, tipNodes } from "./panels/tip.js";
import { viewMenu } from "./panels/view-menu.js";
import { growthPanel } from "./panels/growth.js";
import { segmentsPanel } from "./panels/segments.js";
import { foldTool, viewTools } from "./panels/tools.js";
import { glossary } from "./panels/glossary.js";
import { welcome } from "./panels/welcome.js";
import { waiting } from "./panels/waiting.js";
import { wordsOf } from "./fields.js";
import { measure, patternIn, patternLength, plural } from "./format.js";

const FIRST_SAMPLE = "ball";
/** What the page says of a method where its own words differ. */
const WORDS = {
  cutflow: {
    label: "Cut flow",
    learn: "One step of the cut flow",
    sheet: { energy: "Energy", pieces: "Pieces" },
    empty: "uncut",
    hide: ["Hide seams from here", "Hide seams from here: makes cuts cost more wherever this view sees them"],
    hidden: ["penalty", "Cuts now cost more where this view sees them: the penalty η that is shown. Run moves them out of sight."],
  },
  cones: {
    label: "Cones",
    learn: "How the cones are found",
    sheet: { energy: "Distortion", pieces: "Cones" },
    empty: "unsolved",
    hide: ["Hide cones from here", "Hide cones from here: makes cones cost more wherever this view sees them"],
    hidden: ["cone_cost", "Cones now cost more where this view sees them: the cost that is shown."],
  },
  phasefield: {
    label: "Phase field",
    learn: "How a surface is divided by a phase field",
    sheet: { energy: "Energy", pieces: "Pieces" },
    empty: "undivided",
    hide: ["Hide seams from here", "Hide seams from here"],
    hidden: ["none", ""],
  },
  developable: {
    label: "Developable patches",
    learn: "How patches grow that nearly lie flat",
    sheet: { energy: "Seam", pieces: "Pieces" },
    plot: "Seam, √A",
    empty: "undivided",
    hide: ["Hide seams from here", "Hide seams from here: makes seams cost more wherever this view sees them"],
    hidden: ["penalty", "Seams now cost more where this view sees them. Reset and Run find others."],
  },
};
/** Why what needs a cut cannot be had. */
const BLOCKED = "Repair the mesh first: see Mesh, at the top of the parameters";
/** Steps are taken one after the other: a strip that flashes with each would say less than the step itself. */
const STEP_PATIENCE_MS = 500;
/** How long a tool is given to stop by itself. */
const GRACE_MS = 20_000;
const root = document.documentElement;
const asked = readAddress();

/** What the engine said last. */
const now = {
  mesh: null,
  /** What the doctor said about it. */
  doctor: null,
  values: {},
  method: "cutflow",
  /** The values with which the mesh was opened, by method. */
  opened: {},
  fields: { current: "pieces", options: [] },
  rows: [],
  /** Its sizes in the unit that lengths are shown in, and as they were measured. */
  pattern: null,
  measured: null,
  unit: "mm",
  /** What the engine says of the cut as a whole. */
  note: null,
  scene: null,
  samples: { options: [], current: null },
  /** Numbers of the stages of the next step, for Learn: the last `stages` event. */
  stages: null,
};

const say = toast();
const waits = waiting({
  cancel: (sentence) => client.cancel(sentence),
  stop: stopPreparing,
  mesh: () => now.mesh,
  busy: (isBusy) => meshPanel.busy(isBusy),
});
const error = errorPanel(async () => {
  await client.command({ type: "dismiss_error" });
  status.recover();
});
const status = statusPanel({
  run: () => onCut({ type: "run" }),
  pause: () => client.command({ type: "pause" }),
  step: takeStep,
  reset: () => waits.answer("Going back to the start", "Going back was cancelled.", () => onCut({ type: "reset" })),
});
const symmetry = symmetryPanel({
  find: () => waits.answer("Looking for symmetries", "The search was cancelled.", () => client.command({ type: "find_symmetries" })),
  choose: (ids) => waits.answer("Setting the symmetry", "Setting the symmetry was cancelled.", () => client.command({ type: "set_symmetry", ids })),
});
const cones = coneMethod({
  send: (command) => onCut(command),
  wait: (sentence, cancelled, command) => waits.answer(sentence, cancelled, () => onCut(command)),
  lambda: (value) => client.setParameter("lambda", value),
  views: () => views,
  say: (sentence) => say(sentence),
  toolChanged(isHeld) {
    if (isHeld) {
      brush.put();
      looks.endMeasure();
    }
    tools.held(brush.isOn() || isHeld);
    sayHint();
  },
  facts: (text) => status.figures(text),
});
const segments = segmentsPanel({
  async select(node) {
    await asking("Showing the segment", { type: "select_segment", node });
    showField("weight");
  },
  handOver: () => changing("Starting the cut flow from these segments", { type: "hand_over" }),
});
const growth = growthPanel({
  sew: (patches, joins) => {
    const isWhole = patches.every((patch) => Number.isInteger(patch) && patch >= 0);
    if (isWhole) cutting(joins ? "Joining two pieces" : "Keeping two pieces apart", { type: "sew", patches, joins });
    else say("Pieces are named by the numbers that the flattened view shows.");
  },
  handOver: () => changing("Starting the cut flow from these pieces", { type: "hand_over" }),
});
const feet = { Symmetry: symmetry.node, Sparsity: cones.foot, Segments: segments.node, "Flat pieces": growth.node };
const parameters = parametersPanel(byId("settings"), (id, value) => client.setParameter(id, value), feet, { lambda: cones.path });
// While a slider is held, the engine keeps itself free for its next move.
for (const host of [byId("settings"), byId("lesson")]) {
  host.addEventListener("pointerdown", ({ target }) => {
    if (!target.matches("input[type=range]")) return;
    const letGo = client.hold();
    const over = new AbortController();
    const end = () => {
      over.abort();
      letGo();
    };
    for (const event of ["pointerup", "pointercancel", "blur"]) addEventListener(event, end, { signal: over.signal });
  });
}
const presets = presetsPanel(
  byId("presets"),
  (id) => changing("Setting the preset", { type: "apply_preset", id }),
  (name) => now.samples.options.find((sample) => sample.name === name)?.label,
);
const plot = energyPlot(byId("plot"));
const measures = measuresPanel(byId("measures"));
const pieces = piecesPanel(byId("pieces"), (patch) => views.setHover(patch), {
  fly: (patch) => views.look.flyTo(patch),
  isolate: (patch) => views.look.isolate(patch),
});
const mesh = meshLine(openMeshSection);
const meshPanel = meshSection(byId("mesh-section"), {
  repair: (id) => changing("Repairing", { type: "repair", id }),
  repairAll,
  showFinding: (id) => asking("Marking the finding", { type: "show_finding", id }),
  setUnit,
  setSize,
  prepare: (tool, values) => client.command({ type: "prepare", tool, values }),
});
const empty = emptyState({ openMesh: openMeshSection, repairAll, toPieces: () => asking("Going back to the pieces", { type: "show_finding", id: null }), cut: firstCut, solve: () => onCut({ type: "run" }) });
const workshop = patternPanel(
  {
    show: (isShown) => waits.answer("Making the pattern", "The pattern was cancelled.", () => client.command({ type: "show_pattern", is_shown: isShown })),
    change: (id, value) => client.setParameter(id, value),
    trade: (id) => waits.answer("Making the pattern", "The pattern was cancelled.", () => client.command({ type: "apply_trade", id })),
    nest: () => asking("Beginning a better layout", { type: "nest" }),
    pause: () => client.command({ type: "pause" }),
    allowance: (seam, mm) => asking("Making the pattern", { type: "set_seam_allowance", seam, mm }),
    save,
    setUnit,
    setSize,
  },
);
const exports = exportMenu(save, () => workshop.open());
const [surfaceView, flatView] = [document.querySelector(".view.surface"), document.querySelector(".view.flat")];
const stages = [surfaceView, flatView].map((view) => view.querySelector(".stage"));
const legend = legends(surfaceView.querySelector(".legend"), flatView.querySelector(".said"));
const measureRuler = ruler(flatView.querySelector(".rule"));
const danger = alarm(byId("alarm"), { reveal: showFaults, isMoving: () => status.state() === "running" });
const describe = descriptions(() => ({
  name: now.mesh?.name ?? "The surface",
  marked: marked(),
  scene: now.scene,
  pieces: (now.scene?.patches ?? []).map((_, i) => pieces.piece(i)).filter(Boolean),
  pattern: now.pattern,
}));
const updateLegends = paced(125, () => {
  if (!now.scene) return;
  legend.show(now.scene, now.pattern, marked(), fold.line());
  describe();
});
const fold = foldTool(
  () => waits.answer("Folding the pieces", "Folding was cancelled.", () => onPieces({ type: "fold" })),
  () => client.command({ type: "unfold" }),
);

const views = new Views(stages, {
  renderer: (name) => {
    root.dataset.renderer = name;
    const title = name === "webgpu" ? "WebGPU" : "WebGL2";
    byId("hint").replaceChildren(h("span"), title);
    sayHint();
    byId("hint").title = `Drawn with ${title}. Add ?renderer=${name === "webgpu" ? "webgl" : "webgpu"} to the address for the other.`;
  },
  taken: () => client.sceneTaken(),
  drawn() {
    measureRuler.show(views.pixelsPerUnit(), now.pattern);
    texture.show(now.pattern);
    learn.drawn();
    compare.drawn();
  },
  hover: (patch) => pieces.light(patch, true),
  describe: tipFor,
  looking: {
    isolated: (patch) => looks.isolated(patch),
    ends: (count) => count < 2 && looks.tellEnds(count),
    measured: measureBetween,
    words: fieldWords,
  },
  hoverCone: cones.hoverCone,
  describeCone: cones.describeCone,
  selectCone: cones.selectCone,
  moveCone: cones.moveCone,
  addCone: cones.addCone,
  failed: (reason) => {
    error.show({
      what: "The surfaces cannot be drawn: this browser offers neither WebGPU nor WebGL2.",
      where: reason,
      what_to_do: "Switch hardware acceleration on in the browser's settings, or try another browser. Cutting, measures and exports work all the same.",
    });
  },
});

const texture = textureTool(views, flatView.querySelector(".weave"), {
  refuse: (event) => handlers.error(event),
  // A field would hide the textures of the charts.
  atlas: () => showField("pieces"),
});

const showKeys = keyboardHelp();
const looks = viewMenu({
  side: (id) => views.look.lookFrom(id),
  orthographic: (on) => views.look.setOrthographic(on),
  clip: (clip) => views.look.setClip(clip),
  isolate: isolatePiece,
  measure(on) {
    if (on) {
      brush.put();
      cones.tool.put();
    }
    views.setMeasure(on);
    sayHint();
  },
  clearMeasure() {
    views.look.clearMeasure();
    looks.tellEnds(0);
  },
  keyboard: showKeys,
  say: (sentence) => say(sentence),
});

const brush = brushPanel(
  views,
  {
    paint: (dab) => client.command({ type: "paint", ...dab }),
    rested: () => client.command({ type: "end_stroke" }),
    clear: (channel) => asking("Clearing", { type: "clear_paint", channel }),
    circle: ({ face, x, y, z }) => changing("Starting at a circle", { type: "place_circle", face, place: [x, y, z] }),
    field: showField,
    changed(isOn) {
      if (isOn) {
        cones.tool.put();
        looks.endMeasure();
      }
      tools.held(isOn || cones.tool.isOn());
      sayHint();
    },
  },
  () => ({ fields: now.fields.options, current: now.fields.current }),
);

const tools = viewTools(views, () => {
  brush.put();
  cones.tool.put();
  looks.endMeasure();
});
const tabs = methodTabs(chooseMethod, say);

const saving = autosave({
  make: () => client.saveProject(),
  say,
  about: () => ({ name: now.mesh.name, about: `${words().label}, step ${status.step()}` }),
});
const history = historyPanel((changes, meshes) => {
  brush.drop();
  endFold().then(() => waits.answer("Going through the history", "Going through the history was cancelled.", () => client.travel(changes, meshes)));
});

const keeping = keepCut(() => changing("Putting the cut on this mesh", { type: "keep_cut" }));

const handlers = {
  ...cones.handlers,
  comparison: (event) => compare.show(event),
  methods(event) {
    compare.methods(event);
    tabs.show(event);
    if (event.current !== now.method) toMethod(event.current);
  },
  samples(event) {
    now.samples = event;
    showSamples();
  },
  mesh(event) {
    now.mesh = event;
    saving.renew();
    keeping.end();
    now.doctor = null;
    now.opened = {};
    now.stages = null;
    now.scene = null;
    document.title = `Cutflow – ${event.name}`;
    brush.drop();
    views.look.clear();
    looks.tellEnds(0);
    fold.clear();
    workshop.clear();
    danger.show([], []);
    mesh.show(event);
    meshPanel.show(event);
    plot.clear();
    cones.clear();
    segments.clear();
    growth.clear();
    status.clear();
    error.hideRefusal();
    for (const id of ["export", "share"]) byId(id).disabled = false;
    allow();
  },
  doctor(event) {
    const isNew = now.doctor === null;
    now.doctor = event;
    mesh.judge(event);
    meshPanel.judge(event);
    if (isNew && !event.solvable) sheet.toParameters();
    allow();
  },
  size(event) {
    meshPanel.size(event);
    workshop.size(event);
    now.unit = event.display_unit;
    showPattern();
  },
  tools: (event) => meshPanel.tools(event),
  keep_offer: (event) => keeping.offer(event.from),
  progress: ({ label, fraction }) => waits.progress(label, fraction),
  parameters(event) {
    now.values = event.values;
    now.opened[event.method] ??= event.values;
    cones.specs(event.specs);
    parameters.show(event);
    learn.parameters(event);
    workshop.parameters(event);
  },
  measured: showMeasured,
  trades: (event) => workshop.trades(event),
  pattern: (event) => workshop.show(event),
  presets: (event) => presets.show(event),
  paint_channels(event) {
    brush.offer(event);
    byId("hide-seams").hidden = !brush.offers(words().hidden[0]);
  },
  symmetries(event) {
    symmetry.show(event);
    parameters.summarise();
  },
  fold(event) {
    fold.show(event);
    if (event.is_on) brush.put();
    allow();
  },
  segments(event) {
    segments.show(event);
    parameters.summarise();
  },
  patches(event) {
    growth.show(event);
    parameters.summarise();
  },
  stages(event) {
    now.stages = event;
    learn.update();
  },
  status(event) {
    // The preview is watched while it goes on and ends with its own button.
    waits.prepare(event.state === "preparing" && !fold.isOn() ? event.text : null);
    status.show(event);
    saving.state(event.state);
    cones.status(event);
    explainEmpty();
    learn.update();
  },
  energy(event) {
    plot.add(event);
    status.energy(event);
  },
  measures(event) {
    now.rows = event.rows;
    now.measured = event.pattern ?? null;
    // The table of the cones has its own place for it.
    if (event.note && event.note !== now.note && now.method !== "cones") say(event.note);
    now.note = event.note ?? null;
    measures.show(event.rows);
    pieces.show(event.pieces);
    danger.show(event.rows, event.pieces);
    showPattern();
  },
  fields(event) {
    now.fields = event;
    for (const select of document.querySelectorAll("select.overlay")) {
      const options = event.options.some(({ id }) => id === "pieces")
        ? event.options
        : [{ id: "pieces", label: "Pieces" }, ...event.options];
      select.replaceChildren(...options.map(({ id, label }) => h("option", { value: id }, label)));
    }
    chooseOverlay(event.current ?? "pieces");
  },
  history(event) {
    const { undo, redo } = event;
    history.show(event);
    // Something was done: what could not be done before it is no news any more.
    error.hideRefusal();
    for (const [id, name, text, keys] of [
      ["undo", "Undo", undo, "Ctrl Z"],
      ["redo", "Redo", redo, "Ctrl Shift Z"],
    ]) {
      byId(id).disabled = !text;
      byId(id).title = text ? `${name}: ${text} (${keys})` : `Nothing to ${id}`;
    }
  },
  error(event) {
    showSamples();
    if (!workshop.refuse(event)) error.show(event, true);
  },
  scene() {},
};

const client = new EngineClient({
  events(list, spent, isReplay) {
    if (!isReplay && list.some(({ type }) => type === "mesh")) compare.forget();
    for (const event of list) handlers[event.type]?.(event);
    const steps = list.filter((event) => event.type === "energy" && event.step > 0).length;
    if (spent > 0 && !waits.isPreparing()) {
      status.spent(spent, steps);
      cones.spent(spent);
    }
    if (status.state() !== "running") settle();
  },
  scene(scene) {
    now.scene = scene;
    views.setScene(scene);
    explainEmpty();
    texture.scene(scene);
    updateLegends();
    learn.update();
    compare.scene();
  },
  changed: () => saving.changed(),
  lost(name, file, isClosed) {
    error.show({
      what: isClosed ? `${name} makes the solver stop, so it was closed.` : `${name} stopped the solver twice and is back at its start.`,
      where: "The same mesh with the same settings stopped it several times in a row.",
      what_to_do: "Open it again with other settings, or reduce it first.",
      action: file && { label: "Download its project", run: () => download(file.name, new Blob([file.bytes], { type: file.mime })) },
    });
  },
  restarted(sentence, hasDocument, back) {
    saving.forget();
    waits.end();
    brush.drop();
    symmetry.rest();
    fold.clear();
    if (hasDocument) compare.lose(now.opened);
    else compare.forget();
    say(sentence);
    const [text, given] = hasDocument ? ["Loading the last mesh again", "It was closed, as it took too long to come back."] : ["Starting the solver", "The solver was started again."];
    waits.answer(text, given, () => back);
    if (hasDocument) status.show({ state: "loading", step: 0, text });
    else status.show({ state: "empty", step: 0, text: "Ready: open a mesh or choose a sample" });
  },
  failed(reason) {
    waits.end();
    const event = {
      what: "The solver does not run in this browser.",
      where: reason,
      what_to_do: "Reload the page. Cutflow needs WebAssembly with SIMD: Chrome 91, Firefox 89, Safari 16.4 or newer.",
    };
    error.show(event);
    status.show({ state: "error", step: 0, text: `Error: ${event.what}` });
  },
});

const learn = learnPanel(
  {
    field: showField,
    step: takeStep,
    reset: () => onCut({ type: "reset" }),
    change: (id, value) => client.setParameter(id, value),
    word: glossary().open,
    plain: (on) => views.setPlain(on),
    wires: (on) => views.setWireframe(on || byId("wireframe").getAttribute("aria-pressed") === "true"),
    layout() {
      brush.put();
      cones.tool.put();
      endFold();
    },
    picture: (canvas) => views.copySurface(canvas),
  },
  () => ({
    name: now.mesh?.name ?? "",
    step: status.step(),
    state: status.state(),
    points: plot.points(),
    rows: now.rows,
    fields: now.fields.options,
    current: now.fields.current,
    field: now.scene?.field ?? null,
    scene: now.scene,
    stages: now.stages?.step === status.step() + 1 ? now.stages.stages : [],
    figures: figures(),
  }),
);

const compare = comparePanel({
  send: (command) => client.command(command),
  run: (command) => cutting("Setting the runs up", command),
  wait: changing,
  save,
  picture: (isSurface, width, height) => views.thumbnail(isSurface ? SURFACE : FLAT, width, height),
  opening: () => learn.close(),
});

// What people do.

const words = () => WORDS[now.method] ?? WORDS.cutflow;

/** What Learn says of the method as a whole. */
function figures() {
  if (now.method === "cones") return cones.figures();
  return now.rows.filter(({ now: value }) => value !== null).map(({ label, now: value, unit }) => [label, measure(value, unit)]);
}

async function chooseMethod(id) {
  brush.put();
  cones.tool.put();
  learn.close();
  await endFold();
  await toPieces();
  await setMethod(id);
}

function setMethod(id) {
  return asking(`Changing to ${WORDS[id]?.label ?? id}`, { type: "set_method", id });
}

/** Arranges the page for a method: the engine has changed to it. */
function toMethod(id) {
  now.method = id;
  now.stages = null;
  // What was said was said of the other method.
  say(null);
  root.dataset.method = id;
  plot.clear();
  status.clear();
  const isCones = id === "cones";
  for (const [pane, isShown] of [["energy", !isCones], ["pieces", !isCones], ["distortion", isCones], ["cones", isCones]]) {
    byId(pane).hidden = !isShown;
  }
  const { hide, sheet: names } = words();
  byId("hide-seams").setAttribute("aria-label", hide[0]);
  byId("hide-seams").title = hide[1];
  sheet.name(names);
  byId("energy").querySelector("h3").textContent = names.energy;
  plot.call(words().plot ?? "Total J");
  cones.show(isCones);
  exports.setMethod(id);
  learn.setMethod(id, words().learn);
  byId("parameters").setAttribute("aria-labelledby", `tab-${id}`);
  sayHint();
  explainEmpty();
}

/** Shows the sizes of the pattern in the unit of the page. */
function showPattern() {
  now.pattern = patternIn(now.measured, now.unit);
  if (views.pixelsPerUnit() > 0) {
    measureRuler.show(views.pixelsPerUnit(), now.pattern);
    texture.show(now.pattern);
  }
  updateLegends();
}

/** Shows where the pattern must not be cut: its rows among the measures, and a piece in both views. */
function showFaults(ids, patch) {
  sheet.toMeasures();
  views.setHover(patch);
  measures.reveal(ids);
}

function sayHint() {
  const text = byId("hint").querySelector("span");
  if (!text) return;
  if (brush.isOn()) text.textContent = "Drag to paint, beside the surface to turn · ";
  else if (cones.tool.isOn()) text.textContent = "Click to add a cone, drag to turn · ";
  else if (looks.isMeasuring()) text.textContent = "Click to measure, drag to turn · ";
  else text.textContent = now.method === "cones" ? "Drag to turn, or to move a cone · " : "Drag to turn · ";
}

async function takeStep() {
  if (status.state() === "running") await client.command({ type: "pause" });
  waits.answer("Taking one step", "The step was cancelled.", () => onCut({ type: "step" }), STEP_PATIENCE_MS);
}

/** What is marked on the surface in place of the pieces, as a sentence; null for the pieces. */
function marked() {
  const { doctor } = now;
  if (doctor?.shown) return doctor.findings.find(({ id }) => id === doctor.shown)?.text ?? "What was found";
  return isBlocked() ? "What must be repaired before the mesh can be cut" : null;
}

function isBlocked() {
  return now.doctor ? !now.doctor.solvable : now.mesh?.solvable === false;
}

/** Switches off what the mesh does not allow yet, and says so. */
function allow() {
  const reason = isBlocked() ? BLOCKED : null;
  status.block(reason);
  exports.block(reason);
  byId("learn").disabled = reason !== null;
  fold.block(reason);
  const isFolded = fold.isOn() ? "End the fold preview first" : null;
  brush.block(reason ?? isFolded);
  cones.tool.block(reason ?? isFolded);
  looks.block(reason ?? isFolded);
  byId("compare").disabled = reason !== null;
  compare.block(reason);
  byId("hide-seams").disabled = (reason ?? isFolded) !== null;
  if (reason !== null) learn.close();
  for (const select of document.querySelectorAll("select.overlay")) {
    select.disabled = reason !== null;
    select.title = reason ?? "";
  }
  explainEmpty();
  updateLegends();
}

/** Says why the flattened view has nothing to show, where it has not. */
function explainEmpty() {
  if (isBlocked()) empty.show("blocked", now.doctor?.repair_all.length > 0);
  else if (now.doctor?.shown) empty.show("marked");
  // A method may be refused on a surface whose chart is there from before.
  else empty.show(status.isUncut() && !hasChart() ? words().empty : null);
}

const hasChart = () => now.scene?.patches.some((patch) => patch.has_chart) === true;

function firstCut() {
  return changing("Making the first cut", { type: "reset" });
}

async function toPieces() {
  if (now.doctor?.shown) await client.command({ type: "show_finding", id: null });
}

/** What acts on the cut ends the fold preview: it would show a cut that is no more. */
async function endFold() {
  if (fold.isOn()) await client.command({ type: "unfold" });
}

async function onCut(command) {
  await endFold();
  return onPieces(command);
}

/** Sends a command whose effect is seen on the pieces only. */
async function onPieces(command) {
  await toPieces();
  return client.command(command);
}

function showField(id) {
  if (id === now.fields.current && !now.doctor?.shown) return;
  const ask = () => onPieces({ type: "show_field", id });
  if (status.state() !== "running") return waits.answer("Computing the field", "The field was cancelled.", ask);
  // A run goes on by itself and is no reason to end the engine: the field that was shown is asked for again.
  const before = now.fields.current ?? "pieces";
  return waits.ask("Showing the field after this step", ask, () => {
    chooseOverlay(before);
    client.command({ type: "show_field", id: before });
  });
}

/** What the choices of overlays say. */
function chooseOverlay(id) {
  for (const select of document.querySelectorAll("select.overlay")) select.value = id;
}

async function hideSeams() {
  const eye = views.eye();
  if (!eye) return;
  await waits.answer("Looking at the surface from here", "Hiding was cancelled.", () => onPieces({ type: "hide_from_camera", eye }));
  const [field, sentence] = words().hidden;
  showField(field);
  say(sentence);
}

function openMeshSection() {
  learn.close();
  sheet.toParameters();
  meshPanel.open();
}

function repairAll() {
  return changing("Repairing", { type: "repair_all" });
}

/** Sends a command, with a word and a way out where its answer takes long. */
function asking(sentence, command) {
  return waits.answer(sentence, `${sentence} was cancelled.`, () => client.command(command));
}

/** The same for what gives another mesh or another cut at once. */
async function changing(sentence, command) {
  await endFold();
  await asking(sentence, command);
}

/** The same for what acts on the cut, whose effect is seen on the pieces only. */
function cutting(sentence, command) {
  return waits.answer(sentence, `${sentence} was cancelled.`, () => onCut(command));
}

function setUnit(id) {
  return asking("Setting the unit", { type: "set_unit", id });
}

function setSize(axis, value) {
  return asking("Setting the size", { type: "set_size", axis, value });
}

/** A tool that does not stop is stopped with its engine. A first cut is not: a new engine would begin it again. */
async function stopPreparing() {
  const late = setTimeout(() => {
    if (client.isMaking) client.cancel("The preparation was stopped, and the solver started again.");
  }, GRACE_MS);
  await client.command({ type: "cancel" });
  clearTimeout(late);
}

async function opening(name, open) {
  status.show({ state: "loading", step: 0, text: `Loading ${name}` });
  const answer = await waits.answer(`Loading ${name}`, "Opening was cancelled.", open);
  // The engine says how it went; a refused file leaves the document before it in place.
  return answer.events.some((event) => event.type === "mesh");
}

async function openFile(file, left) {
  if (file.type.startsWith("image/")) {
    texture.take(file);
    return;
  }
  if (left > 0) say(`Opening ${file.name}. ${plural(left, "other file was", "other files were")} left out: one mesh at a time.`);
  try {
    await opening(file.name, async () => client.openMesh(file.name, new Uint8Array(await file.arrayBuffer())));
  } catch (reason) {
    // The browser may refuse to read a file that was moved, or a folder.
    waits.hide();
    const event = {
      what: `${file.name} cannot be read.`,
      where: String(reason?.message ?? reason),
      what_to_do: "Check that it is a file, that it still exists and that you may read it, then open it again.",
    };
    handlers.error(event);
    status.show({ state: "error", step: 0, text: `Error: ${event.what}` });
  }
}

function openSample(name) {
  const option = now.samples.options.find((sample) => sample.name === name);
  return opening(option?.label ?? name, () => client.openSample(name));
}

function showSamples() {
  const { options } = now.samples;
  const current = client.document ? (client.document.sample ?? null) : now.samples.current;
  const select = byId("sample");
  const isKnown = options.some(({ name }) => name === current);
  select.replaceChildren(
    ...(isKnown ? [] : [h("option", { value: "", disabled: true, hidden: true }, "Sample")]),
    ...options.map(({ name, label }) => h("option", { value: name }, label)),
  );
  select.value = isKnown ? current : "";
}

async function save(kind) {
  const picture = { "Surface picture (PNG)": SURFACE, "Pattern picture (PNG)": FLAT }[kind];
  if (picture !== undefined) {
    const blob = await views.picture(picture, exports.scale());
    const stem = now.mesh.name.replace(/\.[^.]*$/, "");
    if (blob) download(`${stem}-${picture === SURFACE ? "surface" : "pattern"}.png`, blob);
    else say("There is no picture yet.");
    return;
  }
  const { file } = await waits.answer(`Making ${kind}`, `${kind} was cancelled.`, () => client.exportFile(kind));
  if (file) download(file.name, new Blob([file.bytes], { type: file.mime }));
}

function tipFor(patch, pointed = {}) {
  if (marked() !== null) return [];
  const { patches = [], field = null } = now.scene ?? {};
  return tipNodes({ patches, field, piece: pieces.piece(patch), pattern: now.pattern }, patch, pointed);
}

/** How values of the field that is shown are written; null where it has none. */
function fieldWords() {
  const field = now.scene?.field;
  if (!hasValues(field) || marked() !== null) return null;
  const { label, value } = wordsOf(field);
  return { name: label, value };
}

/** Shows the piece alone that was pointed at last, or all of them again. */
function isolatePiece() {
  const { look } = views;
  if (look.isolated() < 0 && look.last() < 0) say("Point at a piece first, then press I.");
  else look.isolate(look.last());
}

async function measureBetween(from, to) {
  const spot = ({ face, x, y, z }) => ({ face, place: [x, y, z] });
  await asking("Measuring", { type: "measure", from: spot(from), to: spot(to) });
}

function showMeasured({ straight_mm, along_mm, path }) {
  const length = (mm) => {
    const { unit_length, unit } = patternIn({ width: 0, height: 0, unit: "mm", unit_length: mm }, now.unit);
    return `${patternLength(unit_length, unit)}\u00a0${unit}`;
  };
  const straight = `${length(straight_mm)} straight`;
  const along = along_mm === null ? "no way along the surface" : `${length(along_mm)} along the surface`;
  const onChart = lengthOf(views.look.chartLength(), now.pattern);
  const flat = onChart ? `${onChart} on the chart` : "";
  views.look.showMeasured(path, [along_mm === null ? straight : length(along_mm), onChart ?? ""]);
  looks.tellEnds(2, [along, straight, flat].filter(Boolean).join(" · "));
}

/** Escape puts away what is in hand, the newest first; false if there is nothing. */
function putAway() {
  if (looks.isMeasuring()) looks.endMeasure();
  else if (!views.look.unpin()) {
    if (views.look.isolated() < 0) return false;
    isolatePiece();
  }
  return true;
}

fileSources(openFile);
byId("sample").addEventListener("change", ({ target }) => openSample(target.value));
for (const [id, name] of [["undo", "Undo"], ["redo", "Redo"]]) {
  byId(id).addEventListener("click", () => {
    // What of a stroke is still on its way belongs to what is taken back.
    brush.drop();
    changing(name, { type: id });
  });
}
for (const select of document.querySelectorAll("select.overlay")) {
  select.addEventListener("change", () => showField(select.value));
}
const setting = () => ({
  sample: client.document?.sample ?? null,
  isChanged: client.isChanged,
  name: now.mesh?.name,
  method: now.method,
  specs: parameters.specs(),
  values: now.values,
  opened: now.opened[now.method] ?? {},
  pose: views.pose(),
  field: now.fields.current,
  look: texture.chosen(),
});
shareButton(setting);

byId("hide-seams").addEventListener("click", hideSeams);

const sheet = sheetTabs();

const press = (id) => !byId(id).disabled && !byId(id).hidden && byId(id).click();
listenToKeys({
  press,
  dismiss: () => error.dismiss(),
  held: (name) => brush.key(name) || (!learn.isOpen() && cones.key(name)) || (name === "Escape" && putAway()),
  actions: {
    o: () => byId("file").click(),
    " ": () => press(status.state() === "running" ? "pause" : "run"),
    ".": () => press("step"),
    r: () => press("reset"),
    f: () => (flatView.matches(":hover") ? views.fit(FLAT) : views.fit(SURFACE)),
    w: () => press("wireframe"),
    c: () => press("checkerboard"),
    b: () => learn.isOpen() || press("brush"),
    a: () => learn.isOpen() || press("add-cone"),
    1: () => looks.look("front"),
    "Shift 1": () => looks.look("back"),
    3: () => looks.look("right"),
    "Shift 3": () => looks.look("left"),
    7: () => looks.look("top"),
    "Shift 7": () => looks.look("bottom"),
    5: looks.toggleOrthographic,
    i: isolatePiece,
    x: looks.toggleClip,
    d: () => learn.isOpen() || looks.toggleMeasure(),
    "?": showKeys,
  },
});

// Begin: pictures and solver load side by side.

theme((dark) => views.setDark(dark));
welcome();
splitters();
views.start(asked.renderer);

async function begin() {
  if (asked.embed) {
    embed(() => address(setting()));
    saving.stayInMemory();
  }
  texture.ask(asked.look);
  await waits.answer("Starting the solver", "The solver was started again.", () => client.command({ type: "hello" }));
  // Nothing of another method is shown first.
  if (asked.method !== now.method && tabs.has(asked.method)) await setMethod(asked.method);
  const { options } = now.samples;
  const wanted = asked.sample ?? FIRST_SAMPLE;
  const isKnown = options.length === 0 || options.some(({ name }) => name === wanted);
  if (!isKnown) say(`There is no sample named ${wanted}; this is the ${FIRST_SAMPLE}.`);
  const opened = await openSample(isKnown ? wanted : FIRST_SAMPLE);
  if (!opened) return;
  if (asked.view) views.setPose(asked.view);
  for (const spec of parameters.specs()) {
    const value = spec.id in asked.values ? valueFor(spec, asked.values[spec.id]) : undefined;
    if (value !== undefined && value !== now.values[spec.id]) {
      await asking("Setting the parameters", { type: "set_parameter", id: spec.id, value });
    }
  }
  if (now.fields.options.some(({ id }) => id === asked.field)) showField(asked.field);
  if (asked.run) await client.command({ type: "run" });
  if (asked.stage) learn.openAt(asked.stage);
}

/** The last session is offered beside the sample; what is done by hand from then on is kept for the next visit. */
async function offer() {
  const isAnswered = asked.sample || asked.embed;
  const offered = isAnswered ? null : await offerRestore({
    open: (name, bytes) => opening(name, () => client.openMesh(name, bytes)),
    say,
  });
  // Looking is no work that anybody would miss.
  const acts = ["click", "change", "drop"];
  const act = ({ target, isTrusted }) => {
    if (!isTrusted || target.closest?.(".restore, .stage, .sheet, #theme, #learn, #share, .unsupported")) return;
    saving.store();
  };
  for (const type of acts) addEventListener(type, act, true);
  return offered;
}

begin().finally(() => {
  if (!asked.embed) keepOffline();
});
offer();
