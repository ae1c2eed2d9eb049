// Owns the engine. The page sends requests, the engine works in short slices between them, so that a request waits
// for one slice at most. A scene goes out only after the page has taken the one before: no queue can grow.

import init, { Engine } from "./pkg/engine.js";

const SLICE_MS = 25;
/** WebAssembly can have 4 GiB; who dies with as much as this has asked for more. */
const FULL_BYTES = 3 * 2 ** 30;

let engine = null;
let pageIsReady = true;
let looping = false;

// A message to oneself yields to the requests that have come in meanwhile; timers would add milliseconds.
const next = new MessageChannel();
next.port1.onmessage = () => guarded(slice);

let wasm = null;

const ready = init()
  .then((exports) => {
    wasm = exports;
    engine = new Engine();
    engine.warm_up();
  })
  .catch((error) => die(error));

// While this worker lives it holds a lock; the page waits for it and so hears of a death that nobody could tell.
if (self.navigator.locks) {
  const lock = `cutflow engine ${Math.random()}`;
  self.navigator.locks
    .request(lock, () => {
      self.postMessage({ type: "watch", lock });
      return new Promise(() => {});
    })
    .catch(() => {});
}

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
    case "save":
      reply(request.id, save());
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

/** The project as it is now. A refusal is none of the page's business: nobody asked for it. */
function save() {
  const start = performance.now();
  const { file = null } = refusable(() => ({ file: engine.export_file("Project (JSON)") }));
  return { events: [], file, spent: performance.now() - start };
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
  const isFull = error instanceof RangeError || wasm?.memory.buffer.byteLength > FULL_BYTES;
  const reason = isFull ? "It ran out of memory: reduce the mesh under Prepare, or with another program." : String(error?.message ?? error);
  self.postMessage({ type: "died", reason });
}
