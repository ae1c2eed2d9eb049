// What people ask of the engine: commands, with a word and a way out where an answer takes long.

import { METHODS } from "./method-words.js";

/** Steps are taken one after the other: a strip that flashes with each would say less than the step itself. */
const STEP_PATIENCE_MS = 500;
/** States in which another step may change nothing. */
const ENDS = ["converged", "stalled"];
/** How long a tool is given to stop by itself. */
const GRACE_MS = 20_000;

/** `page` holds the parts of the page, `act` what people do with them. */
export function commands(page, act) {
  const { now } = page;

  async function chooseMethod(id) {
    page.brush.put();
    page.cones.tool.put();
    page.learn.close();
    await endFold();
    await toPieces();
    await setMethod(id);
  }

  function setMethod(id) {
    return asking(`Changing to ${METHODS[id]?.label ?? id}`, { type: "set_method", id });
  }

  async function takeStep() {
    const { status } = page;
    if (status.state() === "running") await page.client.command({ type: "pause" });
    const [step, state] = [status.step(), status.state()];
    await page.waits.answer("Taking one step", "The step was cancelled.", () => onCut({ type: "step" }), STEP_PATIENCE_MS);
    // A step that is taken at the end changes nothing that could be seen.
    if (ENDS.includes(state) && status.step() === step && status.state() === state) page.say("There is no step left: it has converged. Reset begins anew.");
  }

  function goBack() {
    return cutting("Going back to the start", { type: "reset" });
  }

  function firstCut() {
    return changing("Making the first cut", { type: "reset" });
  }

  async function toPieces() {
    if (now.doctor?.shown) await page.client.command({ type: "show_finding", id: null });
  }

  /** What acts on the cut ends the fold preview: it would show a cut that is no more. */
  async function endFold() {
    if (page.fold.isOn()) await page.client.command({ type: "unfold" });
  }

  async function onCut(command) {
    await endFold();
    return onPieces(command);
  }

  /** Sends a command whose effect is seen on the pieces only. */
  async function onPieces(command) {
    await toPieces();
    return page.client.command(command);
  }

  function showField(id) {
    if (id === now.fields.current && !now.doctor?.shown) return;
    const ask = () => onPieces({ type: "show_field", id });
    if (page.status.state() !== "running") return page.waits.answer("Computing the field", "The field was cancelled.", ask);
    // A run goes on by itself and is no reason to end the engine: the field that was shown is asked for again.
    const before = now.fields.current ?? "pieces";
    return page.waits.ask("Showing the field after this step", ask, () => {
      chooseOverlay(before);
      page.client.command({ type: "show_field", id: before });
    });
  }

  /** What the choices of overlays say. */
  function chooseOverlay(id) {
    for (const select of document.querySelectorAll("select.overlay")) select.value = id;
  }

  async function hideSeams() {
    const eye = page.views.eye();
    if (!eye) return;
    await page.waits.answer("Looking at the surface from here", "Hiding was cancelled.", () => onPieces({ type: "hide_from_camera", eye }));
    const [field, sentence] = act.words().hidden;
    showField(field);
    page.say(sentence);
  }

  function repairAll() {
    return changing("Repairing", { type: "repair_all" });
  }

  /** Sends a command, with a word and a way out where its answer takes long. */
  function asking(sentence, command) {
    return page.waits.answer(sentence, `${sentence} was cancelled.`, () => page.client.command(command));
  }

  /** The same for what gives another mesh or another cut at once. */
  async function changing(sentence, command) {
    await endFold();
    await asking(sentence, command);
  }

  /** The same for what acts on the cut, whose effect is seen on the pieces only. */
  function cutting(sentence, command) {
    return page.waits.answer(sentence, `${sentence} was cancelled.`, () => onCut(command));
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
      if (page.client.isMaking) page.client.cancel("The preparation was stopped, and the solver started again.");
    }, GRACE_MS);
    await page.client.command({ type: "cancel" });
    clearTimeout(late);
  }

  async function measureBetween(from, to) {
    const spot = ({ face, x, y, z }) => ({ face, place: [x, y, z] });
    await asking("Measuring", { type: "measure", from: spot(from), to: spot(to) });
  }

  return {
    chooseMethod,
    setMethod,
    takeStep,
    firstCut,
    goBack,
    toPieces,
    endFold,
    onCut,
    onPieces,
    showField,
    chooseOverlay,
    hideSeams,
    repairAll,
    asking,
    changing,
    cutting,
    setUnit,
    setSize,
    stopPreparing,
    measureBetween,
  };
}
