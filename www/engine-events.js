// What the engine says, and what is made of it: its events go to the panels.

import { byId, h, settle } from "./dom.js";
import { download } from "./panels/export-menu.js";

/** What is done with each event, by its type. `page` holds the parts of the page, `act` what people do with them. */
export function eventHandlers(page, act) {
  const { now } = page;
  return {
    ...page.cones.handlers,
    comparison: (event) => page.compare.show(event),
    methods(event) {
      page.compare.methods(event);
      page.tabs.show(event);
      if (event.current !== now.method) act.toMethod(event.current);
    },
    samples(event) {
      now.samples = event;
      act.showSamples();
    },
    mesh(event) {
      now.mesh = event;
      page.saving.renew();
      page.keeping.end();
      now.doctor = null;
      now.opened = {};
      now.stages = null;
      now.scene = null;
      document.title = `Cutflow – ${event.name}`;
      page.brush.drop();
      page.views.look.clear();
      page.looks.tellEnds(0);
      page.fold.clear();
      page.workshop.clear();
      page.danger.show([], []);
      page.mesh.show(event);
      page.meshPanel.show(event);
      page.plot.clear();
      page.cones.clear();
      page.segments.clear();
      page.growth.clear();
      page.status.clear();
      page.error.hideRefusal();
      for (const id of ["export", "share"]) byId(id).disabled = false;
      act.allow();
    },
    doctor(event) {
      const isNew = now.doctor === null;
      now.doctor = event;
      page.mesh.judge(event);
      page.meshPanel.judge(event);
      if (isNew && !event.solvable) page.sheet.toParameters();
      act.allow();
    },
    size(event) {
      page.meshPanel.size(event);
      page.workshop.size(event);
      now.unit = event.display_unit;
      act.showPattern();
    },
    tools: (event) => page.meshPanel.tools(event),
    keep_offer: (event) => page.keeping.offer(event.from),
    progress: ({ label, fraction }) => page.waits.progress(label, fraction),
    parameters(event) {
      now.values = event.values;
      now.opened[event.method] ??= event.values;
      page.cones.specs(event.specs);
      page.parameters.show(event);
      page.learn.parameters(event);
      page.workshop.parameters(event);
    },
    measured: act.showMeasured,
    trades: (event) => page.workshop.trades(event),
    pattern: (event) => page.workshop.show(event),
    presets: (event) => page.presets.show(event),
    paint_channels(event) {
      page.brush.offer(event);
      byId("hide-seams").hidden = !page.brush.offers(act.words().hidden[0]);
    },
    symmetries(event) {
      page.symmetry.show(event);
      page.parameters.summarise();
    },
    fold(event) {
      page.fold.show(event);
      if (event.is_on) page.brush.put();
      act.allow();
    },
    segments(event) {
      page.segments.show(event);
      page.parameters.summarise();
    },
    patches(event) {
      page.growth.show(event);
      page.parameters.summarise();
    },
    stages(event) {
      now.stages = event;
      page.learn.update();
    },
    status(event) {
      // The preview is watched while it goes on and ends with its own button.
      page.waits.prepare(event.state === "preparing" && !page.fold.isOn() ? event.text : null);
      page.status.show(event);
      page.saving.state(event.state);
      page.cones.status(event);
      act.explainEmpty();
      page.learn.update();
    },
    energy(event) {
      page.plot.add(event);
      page.status.energy(event);
    },
    measures(event) {
      now.rows = event.rows;
      now.measured = event.pattern ?? null;
      // The table of the cones has its own place for it.
      if (event.note && event.note !== now.note && now.method !== "cones") page.say(event.note);
      now.note = event.note ?? null;
      page.measures.show(event.rows);
      page.pieces.show(event.pieces);
      page.danger.show(event.rows, event.pieces);
      act.showPattern();
    },
    fields(event) {
      now.fields = event;
      for (const select of document.querySelectorAll("select.overlay")) {
        const options = event.options.some(({ id }) => id === "pieces")
          ? event.options
          : [{ id: "pieces", label: "Pieces" }, ...event.options];
        select.replaceChildren(...options.map(({ id, label }) => h("option", { value: id }, label)));
      }
      act.chooseOverlay(event.current ?? "pieces");
    },
    history(event) {
      const { undo, redo } = event;
      page.history.show(event);
      // Something was done: what could not be done before it is no news any more.
      page.error.hideRefusal();
      for (const [id, name, text, keys] of [
        ["undo", "Undo", undo, "Ctrl Z"],
        ["redo", "Redo", redo, "Ctrl Shift Z"],
      ]) {
        byId(id).disabled = !text;
        byId(id).title = text ? `${name}: ${text} (${keys})` : `Nothing to ${id}`;
      }
    },
    error(event) {
      act.showSamples();
      if (!page.workshop.refuse(event)) page.error.show(event, true);
    },
    scene() {},
  };
}

/** What the engine's client is told to do: with events, scenes, and when an engine is lost. */
export function engineListener(page, act) {
  const { now } = page;
  return {
    events(list, spent, isReplay) {
      if (!isReplay && list.some(({ type }) => type === "mesh")) page.compare.forget();
      for (const event of list) page.handlers[event.type]?.(event);
      const steps = list.filter((event) => event.type === "energy" && event.step > 0).length;
      if (spent > 0 && !page.waits.isPreparing()) {
        page.status.spent(spent, steps);
        page.cones.spent(spent);
      }
      if (page.status.state() !== "running") settle();
    },
    scene(scene) {
      now.scene = scene;
      page.views.setScene(scene);
      act.explainEmpty();
      page.texture.scene(scene);
      page.updateLegends();
      page.learn.update();
      page.compare.scene();
    },
    changed: () => page.saving.changed(),
    lost(name, file, isClosed) {
      page.error.show({
        what: isClosed ? `${name} makes the solver stop, so it was closed.` : `${name} stopped the solver twice and is back at its start.`,
        where: "The same mesh with the same settings stopped it several times in a row.",
        what_to_do: "Open it again with other settings, or reduce it first.",
        action: file && { label: "Download its project", run: () => download(file.name, new Blob([file.bytes], { type: file.mime })) },
      });
    },
    restarted(sentence, hasDocument, back) {
      page.saving.forget();
      page.waits.end();
      page.brush.drop();
      page.symmetry.rest();
      page.fold.clear();
      if (hasDocument) page.compare.lose(now.opened);
      else page.compare.forget();
      page.say(sentence);
      const text = hasDocument ? "Loading the last mesh again" : "Starting the solver";
      page.waits.answer(text, hasDocument ? "It was closed, as it took too long to come back." : "The solver was started again.", () => back);
      if (hasDocument) page.status.show({ state: "loading", step: 0, text });
      else act.showNothing();
    },
    failed(reason) {
      page.waits.end();
      const event = {
        what: "The solver does not run in this browser.",
        where: reason,
        what_to_do: "Reload the page. Cutflow needs WebAssembly with SIMD: Chrome 91, Firefox 89, Safari 16.4 or newer.",
      };
      page.error.show(event);
      page.status.show({ state: "error", step: 0, text: `Error: ${event.what}` });
    },
  };
}
