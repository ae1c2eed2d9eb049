// The page's end of the worker: requests out, events and scenes in, and a new worker when the old one has died.
//
// What it keeps is enough to bring a document back: where the mesh came from and the parameters last reported.

/** How often a document is brought back before the page gives up, and how long a worker must live to be trusted. */
const ATTEMPTS = 3;
const TRUSTED_MS = 10_000;
/** Earlier meshes kept for Undo. */
const KNOWN = 4;

export class EngineClient {
  #on;
  #worker = null;
  #waiting = new Map();
  #nextId = 1;
  #latest = new Map();
  #deaths = 0;
  #trust = 0;

  /** Where the open document came from: `{ sample }` or `{ name, bytes }`. */
  document = null;
  #opening = null;
  #known = new Map();
  #values = {};

  /**
   * @param on `events(list, spent)`, `scene(scene)`, `restarted(sentence, hasDocument)`, `failed(reason)`
   */
  constructor(on) {
    this.#on = on;
    this.#spawn();
  }

  /** Whether a mesh is being opened now. */
  get isOpening() {
    return this.#opening !== null;
  }

  /** Sends one command; resolves when the engine has handled it. */
  command(command) {
    return this.#request({ type: "command", command });
  }

  /** Sends the newest value of a parameter: while one is on its way, values in between are left out. */
  setParameter(id, value) {
    const isBusy = this.#latest.has(id);
    this.#latest.set(id, value);
    if (!isBusy) this.#sendLatest(id);
  }

  async #sendLatest(id) {
    const value = this.#latest.get(id);
    await this.command({ type: "set_parameter", id, value });
    if (this.#latest.get(id) === value) this.#latest.delete(id);
    else if (this.#latest.has(id)) this.#sendLatest(id);
  }

  openSample(sample) {
    return this.#open({ sample });
  }

  openMesh(name, bytes) {
    return this.#open({ name, bytes });
  }

  async #open(source) {
    this.#opening = source;
    const answer = await this.#send(source);
    if (this.#opening === source) this.#opening = null;
    return answer;
  }

  #send(source) {
    if (source.sample) {
      return this.#request({ type: "command", command: { type: "open_sample", name: source.sample } }, [], source);
    }
    // The worker is given a copy: the page's own bytes are what a restart needs.
    const copy = source.bytes.slice().buffer;
    return this.#request({ type: "open", name: source.name, bytes: copy }, [copy], source);
  }

  /** The file of an export item, as `file` of the answer; without one an error event has said why. */
  exportFile(kind) {
    return this.#request({ type: "export", kind });
  }

  /** The page has taken the last scene: the next may come. */
  sceneTaken() {
    this.#worker?.postMessage({ type: "taken" });
  }

  /** Throws the worker away in the middle of its work and brings the last good document back. */
  cancel() {
    this.#revive("Opening was cancelled.");
  }

  #spawn() {
    const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module", name: "cutflow engine" });
    worker.onmessage = ({ data }) => this.#receive(data);
    worker.onerror = (event) => {
      event.preventDefault();
      this.#died(event.message || "the worker could not be loaded");
    };
    this.#worker = worker;
    clearTimeout(this.#trust);
    this.#trust = setTimeout(() => (this.#deaths = 0), TRUSTED_MS);
  }

  #request(request, transfer = [], source = null) {
    if (!this.#worker) return new Promise(() => {});
    const id = this.#nextId++;
    return new Promise((resolve) => {
      this.#waiting.set(id, { resolve, source });
      this.#worker.postMessage({ ...request, id }, transfer);
    });
  }

  #receive(message) {
    switch (message.type) {
      case "events":
        this.#report(message.events, message.spent, null);
        break;
      case "reply": {
        const { resolve, source } = this.#waiting.get(message.id);
        this.#waiting.delete(message.id);
        this.#report(message.events, 0, source);
        resolve(message);
        break;
      }
      case "scene":
        this.#on.scene(message.scene);
        break;
      case "died":
        this.#died(message.reason);
        break;
    }
  }

  #report(events, spent, source) {
    for (const event of events) {
      if (event.type === "parameters") this.#values = event.values;
      if (event.type === "mesh") {
        // Undo may bring an earlier mesh back, known by its name.
        this.document = source ?? this.#known.get(event.name) ?? this.document;
        this.#known.delete(event.name);
        this.#known.set(event.name, this.document);
        if (this.#known.size > KNOWN) this.#known.delete(this.#known.keys().next().value);
      }
    }
    this.#on.events(events, spent);
  }

  #died(reason) {
    this.#deaths += 1;
    const lost = this.#opening ?? this.document;
    const name = lost?.sample ?? lost?.name;
    console.warn(`The engine stopped: ${reason}`);
    if (this.#deaths > ATTEMPTS || !lost) {
      this.#discard();
      this.#on.failed(reason);
      return;
    }
    this.#revive(
      this.#opening
        ? `The solver stopped while opening ${name} and was started again.`
        : `The solver stopped and was started again; ${name} is back at its start.`,
    );
  }

  #discard() {
    this.#worker?.terminate();
    this.#worker = null;
    // Requests to a dead worker are never answered: whoever awaits them must not go on.
    this.#waiting.clear();
    this.#latest.clear();
    this.#opening = null;
  }

  async #revive(sentence) {
    // Parameters may be what kills it: they are left out of the second attempt, the document out of the third.
    const source = this.#deaths < ATTEMPTS ? this.document : null;
    const wanted = this.#deaths < 2 ? { ...this.#values } : {};
    this.#discard();
    this.#spawn();
    this.#on.restarted(sentence, source !== null);
    await this.command({ type: "hello" });
    if (!source) return;
    await this.#open(source);
    for (const [id, value] of Object.entries(wanted)) {
      if (this.#values[id] !== value) await this.command({ type: "set_parameter", id, value });
    }
  }
}
