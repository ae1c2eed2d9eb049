// Wires the page together: the engine's events go to the panels, what people do goes to the engine as commands. The
// page itself holds no geometry; it draws, each animation frame, the newest scene that the worker has sent.

import { arrangement } from "./arrangement.js";
import { autosave } from "./autosave.js";
import { begin, offer } from "./begin.js";
import { commands } from "./commands.js";
import { coneMethod } from "./cones.js";
import { byId, h, paced } from "./dom.js";
import { EngineClient } from "./engine-client.js";
import { engineListener, eventHandlers } from "./engine-events.js";
import { files } from "./files.js";
import { listenToShortcuts } from "./shortcuts.js";
import { keepOffline } from "./offline.js";
import { FLAT, SURFACE } from "./view-names.js";
import { Views } from "./views.js";
import { alarm } from "./panels/alarm.js";
import { brushPanel } from "./panels/brush.js";
import { comparePanel } from "./panels/compare.js";
import { descriptions } from "./panels/describe.js";
import { fileSources } from "./panels/drop.js";
import { emptyState } from "./panels/empty.js";
import { errorPanel, toast } from "./panels/error.js";
import { exportMenu } from "./panels/export-menu.js";
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
import { ruler } from "./panels/ruler.js";
import { readAddress, shareButton } from "./panels/share.js";
import { splitters } from "./panels/splitters.js";
import { statusPanel } from "./panels/status.js";
import { symmetryPanel } from "./panels/symmetry.js";
import { textureTool } from "./panels/texture.js";
import { theme } from "./panels/theme.js";
import { methodTabs, sheetTabs } from "./panels/tabs.js";
import { viewMenu } from "./panels/view-menu.js";
import { growthPanel } from "./panels/growth.js";
import { segmentsPanel } from "./panels/segments.js";
import { foldTool, viewTools } from "./panels/tools.js";
import { glossary } from "./panels/glossary.js";
import { welcome } from "./panels/welcome.js";
import { waiting } from "./panels/waiting.js";

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

/** The parts of the page, and what people do with them. Filled in below: they need each other. */
const [page, act] = [{ now }, {}];
Object.assign(act, commands(page, act), files(page, act), arrangement(page, act));

const say = toast();
const waits = waiting({
  cancel: (sentence) => client.cancel(sentence),
  stop: act.stopPreparing,
  mesh: () => now.mesh,
  busy: (isBusy) => meshPanel.busy(isBusy),
});
const error = errorPanel(async () => {
  await client.command({ type: "dismiss_error" });
  status.recover();
});
const status = statusPanel({
  run: () => act.onCut({ type: "run" }),
  pause: () => client.command({ type: "pause" }),
  step: act.takeStep,
  reset: act.goBack,
});
const symmetry = symmetryPanel({
  find: () => waits.answer("Looking for symmetries", "The search was cancelled.", () => client.command({ type: "find_symmetries" })),
  choose: (ids) => waits.answer("Setting the symmetry", "Setting the symmetry was cancelled.", () => client.command({ type: "set_symmetry", ids })),
});
const cones = coneMethod({
  send: (command) => act.onCut(command),
  wait: (sentence, cancelled, command) => waits.answer(sentence, cancelled, () => act.onCut(command)),
  lambda: (value) => client.setParameter("lambda", value),
  views: () => views,
  say: (sentence) => say(sentence),
  toolChanged(isHeld) {
    if (isHeld) {
      brush.put();
      looks.endMeasure();
    }
    tools.held(brush.isOn() || isHeld);
    act.sayHint();
  },
  facts: (text) => status.figures(text),
});
const segments = segmentsPanel({
  async select(node) {
    await act.asking("Showing the segment", { type: "select_segment", node });
    act.showField("weight");
  },
  handOver: () => act.changing("Starting the cut flow from these segments", { type: "hand_over" }),
});
const growth = growthPanel({
  sew: (patches, joins) => {
    const isWhole = patches.every((patch) => Number.isInteger(patch) && patch >= 0);
    if (isWhole) act.cutting(joins ? "Joining two pieces" : "Keeping two pieces apart", { type: "sew", patches, joins });
    else say("Pieces are named by the numbers that the flattened view shows.");
  },
  handOver: () => act.changing("Starting the cut flow from these pieces", { type: "hand_over" }),
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
  (id) => act.changing("Setting the preset", { type: "apply_preset", id }),
  (name) => now.samples.options.find((sample) => sample.name === name)?.label,
);
const plot = energyPlot(byId("plot"));
const measures = measuresPanel(byId("measures"));
const pieces = piecesPanel(byId("pieces"), (patch) => views.setHover(patch), {
  fly: (patch) => views.look.flyTo(patch),
  isolate: (patch) => views.look.isolate(patch),
});
const mesh = meshLine(act.openMeshSection);
const meshPanel = meshSection(byId("mesh-section"), {
  repair: (id) => act.changing("Repairing", { type: "repair", id }),
  repairAll: act.repairAll,
  showFinding: (id) => act.asking("Marking the finding", { type: "show_finding", id }),
  setUnit: act.setUnit,
  setSize: act.setSize,
  prepare: (tool, values) => client.command({ type: "prepare", tool, values }),
});
const empty = emptyState({
  chooseMesh: () => byId("file").click(),
  openMesh: act.openMeshSection,
  repairAll: act.repairAll,
  toPieces: () => act.asking("Going back to the pieces", { type: "show_finding", id: null }),
  cut: act.firstCut,
  solve: () => act.onCut({ type: "run" }),
});
const workshop = patternPanel(
  {
    show: (isShown) => waits.answer("Making the pattern", "The pattern was cancelled.", () => client.command({ type: "show_pattern", is_shown: isShown })),
    change: (id, value) => client.setParameter(id, value),
    trade: (id) => waits.answer("Making the pattern", "The pattern was cancelled.", () => client.command({ type: "apply_trade", id })),
    nest: () => act.asking("Beginning a better layout", { type: "nest" }),
    pause: () => client.command({ type: "pause" }),
    allowance: (seam, mm) => act.asking("Making the pattern", { type: "set_seam_allowance", seam, mm }),
    save: act.save,
    setUnit: act.setUnit,
    setSize: act.setSize,
  },
);
const exports = exportMenu(act.save, () => workshop.open());
const [surfaceView, flatView] = [document.querySelector(".view.surface"), document.querySelector(".view.flat")];
const stages = [surfaceView, flatView].map((view) => view.querySelector(".stage"));
const legend = legends(surfaceView.querySelector(".legend"), flatView.querySelector(".said"));
const measureRuler = ruler(flatView.querySelector(".rule"));
const danger = alarm(byId("alarm"), { reveal: act.showFaults, isMoving: () => status.state() === "running" });
const describe = descriptions(() => ({
  name: now.mesh?.name ?? "The surface",
  marked: act.marked(),
  scene: now.scene,
  pieces: (now.scene?.patches ?? []).map((_, i) => pieces.piece(i)).filter(Boolean),
  pattern: now.pattern,
}));
const updateLegends = paced(125, () => {
  if (!now.scene) return;
  legend.show(now.scene, now.pattern, act.marked(), fold.line());
  describe();
});
const fold = foldTool(
  () => waits.answer("Folding the pieces", "Folding was cancelled.", () => act.onPieces({ type: "fold" })),
  () => client.command({ type: "unfold" }),
);

const views = new Views(stages, {
  renderer: (name) => {
    document.documentElement.dataset.renderer = name;
    const title = name === "webgpu" ? "WebGPU" : "WebGL2";
    byId("hint").replaceChildren(h("span"), title);
    act.sayHint();
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
  describe: act.tipFor,
  looking: {
    isolated: (patch) => looks.isolated(patch),
    ends: (count) => count < 2 && looks.tellEnds(count),
    measured: act.measureBetween,
    words: act.fieldWords,
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
  refuse: (event) => page.handlers.error(event),
  // A field would hide the textures of the charts.
  atlas: () => act.showField("pieces"),
});

const showKeys = keyboardHelp();
const looks = viewMenu({
  side: (id) => views.look.lookFrom(id),
  orthographic: (on) => views.look.setOrthographic(on),
  clip: (clip) => views.look.setClip(clip),
  isolate: act.isolatePiece,
  measure(on) {
    if (on) {
      brush.put();
      cones.tool.put();
    }
    views.setMeasure(on);
    act.sayHint();
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
    clear: (channel) => act.asking("Clearing", { type: "clear_paint", channel }),
    circle: ({ face, x, y, z }) => act.changing("Starting at a circle", { type: "place_circle", face, place: [x, y, z] }),
    field: act.showField,
    changed(isOn) {
      if (isOn) {
        cones.tool.put();
        looks.endMeasure();
      }
      tools.held(isOn || cones.tool.isOn());
      act.sayHint();
    },
  },
  () => ({ fields: now.fields.options, current: now.fields.current }),
);

const tools = viewTools(views, () => {
  brush.put();
  cones.tool.put();
  looks.endMeasure();
});
const tabs = methodTabs(act.chooseMethod, say);

const saving = autosave({
  make: () => client.saveProject(),
  say,
  about: () => ({ name: now.mesh.name, about: `${act.words().label}, step ${status.step()}` }),
});
const history = historyPanel((changes, meshes) => {
  brush.drop();
  act.endFold().then(() => waits.answer("Going through the history", "Going through the history was cancelled.", () => client.travel(changes, meshes)));
});

const keeping = keepCut(() => act.changing("Putting the cut on this mesh", { type: "keep_cut" }));

const client = new EngineClient(engineListener(page, act));

const learn = learnPanel(
  {
    field: act.showField,
    step: act.takeStep,
    reset: act.goBack,
    change: (id, value) => client.setParameter(id, value),
    word: glossary().open,
    plain: (on) => views.setPlain(on),
    wires: (on) => views.setWireframe(on || byId("wireframe").getAttribute("aria-pressed") === "true"),
    layout() {
      brush.put();
      cones.tool.put();
      act.endFold();
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
    figures: act.figures(),
  }),
);

const compare = comparePanel({
  send: (command) => client.command(command),
  run: (command) => act.cutting("Setting the runs up", command),
  wait: act.changing,
  save: act.save,
  picture: (isSurface, width, height) => views.thumbnail(isSurface ? SURFACE : FLAT, width, height),
  opening: () => learn.close(),
});

fileSources(act.openFile);
byId("sample").addEventListener("change", ({ target }) => act.openSample(target.value));
for (const [id, name] of [["undo", "Undo"], ["redo", "Redo"]]) {
  byId(id).addEventListener("click", () => {
    // What of a stroke is still on its way belongs to what is taken back.
    brush.drop();
    act.changing(name, { type: id });
  });
}
for (const select of document.querySelectorAll("select.overlay")) {
  select.addEventListener("change", () => act.showField(select.value));
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

byId("hide-seams").addEventListener("click", act.hideSeams);

const sheet = sheetTabs();

/** All parts, for those that the engine's events and people's wishes concern. */
Object.assign(page, {
  say, waits, error, status, symmetry, cones, segments, growth, parameters, presets, plot, measures, pieces, mesh, meshPanel, empty, workshop,
  exports, measureRuler, danger, updateLegends, fold, views, texture, looks, brush, tools, tabs, saving, history, keeping, client, learn, compare,
  sheet, setting,
});
page.handlers = eventHandlers(page, act);
listenToShortcuts(page, act, () => flatView.matches(":hover"), showKeys);

// Begin: pictures and solver load side by side.

theme((dark) => views.setDark(dark));
welcome();
splitters();
views.start(asked.renderer);

begin(page, act, asked).finally(() => {
  if (!asked.embed) keepOffline();
});
offer(page, act, asked);
