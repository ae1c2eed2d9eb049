// Owns the engine. The page sends requests, the engine works in short slices between them, so that a request waits
// for one slice at most. A scene goes out only after the page has taken the one before: no queue can grow.

import init, { Engine } from "./pkg/engine.js";

const SLICE_MS = 25;

let engine = null;
let pageIsReady = true;
let looping = false;

// A message to oneself yields to the requests that have come in meanwhile; timers would add milliseconds.
const next = new MessageChannel();
next.port1.onmessage = () => guarded(slice);

const ready = init()
  .then(() => {
    engine = new Engine();
    engine.warm_up();
  })
  .catch((error) => die(error));

self.onmessage = async ({ data }) => {
  await ready;
  if (engine) guarded(() => answer(data));
};

function answer(request) {
  switch (request.type) {
    case "taken":
      pageIsReady = true;
      offerScene();
      return;
    case "command":
      reply(request.id, refusable(() => ({ events: engine.handle(request.command) })));
      break;
    case "open":
      reply(request.id, { events: engine.open(request.name, new Uint8Array(request.bytes)) });
      break;
    case "export":
      reply(request.id, refusable(() => ({ events: [], file: engine.export_file(request.kind) })));
      break;
  }
  offerScene();
  if (!looping && engine.is_running()) {
    looping = true;
    next.port2.postMessage(null);
  }
}

function slice() {
  looping = engine.is_running();
  if (!looping) return;
  const start = performance.now();
  const events = engine.advance(SLICE_MS);
  self.postMessage({ type: "events", events, spent: performance.now() - start });
  offerScene();
  next.port2.postMessage(null);
}

// A refusal has three parts and is an answer; anything else that is thrown means that the engine is broken.
function refusable(work) {
  try {
    return work();
  } catch (error) {
    if (typeof error?.what !== "string") throw error;
    const { what, where, what_to_do } = error;
    return { events: [{ type: "error", what, where, what_to_do }] };
  }
}

function reply(id, content) {
  self.postMessage({ type: "reply", id, ...content }, content.file ? [content.file.bytes.buffer] : []);
}

function offerScene() {
  if (!pageIsReady) return;
  const scene = engine.scene();
  if (!scene) return;
  pageIsReady = false;
  const parts = [...Object.values(scene), ...Object.values(scene.layers ?? {})];
  const buffers = parts.filter(ArrayBuffer.isView).map((view) => view.buffer);
  self.postMessage({ type: "scene", scene }, [...new Set(buffers)]);
  const events = engine.late();
  if (events.length > 0) self.postMessage({ type: "events", events, spent: 0 });
}

function guarded(work) {
  try {
    work();
  } catch (error) {
    die(error);
  }
}

// After a panic the instance is unusable: say so and wait to be replaced.
function die(error) {
  engine = null;
  looping = false;
  self.postMessage({ type: "died", reason: String(error?.message ?? error) });
}
