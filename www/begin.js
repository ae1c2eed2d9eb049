// How a visit begins: with what the address asks for, a sample else, and the session that was left last.

import { embed } from "./panels/embed.js";
import { offerRestore } from "./panels/restore.js";
import { address, valueFor } from "./panels/share.js";

const FIRST_SAMPLE = "ball";
/** In place of a sample: who always brings a mesh waits for none. */
const NO_SAMPLE = "none";

/** Brings what the address asks for: sample, method, parameters, view. */
export async function begin(page, act, asked) {
  const { now } = page;
  if (asked.embed) {
    embed(() => address(page.setting()));
    page.saving.stayInMemory();
  }
  page.texture.ask(asked.look);
  // A link without a sample is about a mesh that somebody brings: the first one.
  if (asked.sample === null || asked.sample === NO_SAMPLE) act.bringToFirst(() => apply(page, act, asked));
  await page.waits.answer("Starting the solver", "The solver was started again.", () => page.client.command({ type: "hello" }));
  // Nothing of another method is shown first.
  if (asked.method !== now.method && page.tabs.has(asked.method)) await act.setMethod(asked.method);
  // Somebody may have been faster.
  if (page.client.isOpening || page.client.document) return;
  if (asked.sample === NO_SAMPLE) {
    act.showNothing();
    return;
  }
  const { options } = now.samples;
  const wanted = asked.sample ?? FIRST_SAMPLE;
  const isKnown = options.length === 0 || options.some(({ name }) => name === wanted);
  if (!isKnown) page.say(`There is no sample named ${wanted}; this is the ${FIRST_SAMPLE}.`);
  const opened = await act.openSample(isKnown ? wanted : FIRST_SAMPLE, true);
  if (!opened) return;
  await apply(page, act, asked);
  if (asked.run) await page.client.command({ type: "run" });
  if (asked.stage) page.learn.openAt(asked.stage);
}

/** Gives the open document the parameters and the looks that the address asks for; they mean nothing to another method. */
async function apply(page, act, asked) {
  const { now } = page;
  if (asked.method !== now.method && page.tabs.has(asked.method)) return;
  if (asked.view) page.views.setPose(asked.view);
  for (const spec of page.parameters.specs()) {
    const value = spec.id in asked.values ? valueFor(spec, asked.values[spec.id]) : undefined;
    if (value !== undefined && value !== now.values[spec.id]) {
      await act.asking("Setting the parameters", { type: "set_parameter", id: spec.id, value });
    }
  }
  if (now.fields.options.some(({ id }) => id === asked.field)) act.showField(asked.field);
}

/** The last session is offered beside the sample; what is done by hand from then on is kept for the next visit. */
export async function offer(page, act, asked) {
  const isAnswered = asked.sample || asked.embed;
  const offered = isAnswered ? null : await offerRestore({
    open: (name, bytes) => act.opening(name, () => page.client.openMesh(name, bytes)),
    say: page.say,
  });
  // Looking is no work that anybody would miss.
  const acts = ["click", "change", "drop"];
  const store = ({ target, isTrusted }) => {
    if (!isTrusted || target.closest?.(".restore, .stage, .sheet, #theme, #learn, #share, .unsupported")) return;
    page.saving.store();
  };
  for (const type of acts) addEventListener(type, store, true);
  return offered;
}
