// The page's end of the worker: requests out, events and scenes in, and a new worker when the old one has died.
//
// A document comes back from the project that was saved last. Where there is none, what is remembered here has to do: where
// the mesh came from, the repairs and preparations that made it what it is, its parameters and its real size.

/** How often a document is brought back before the page gives up, and how long a worker must live to be trusted. */
const ATTEMPTS = 3;
const TRUSTED_MS = 10_000;
/** Meshes that Undo and Redo can go to, the open one included. */
const KNOWN = 6;
/** Commands after which the mesh is another one. */
const CHANGES = ["repair", "repair_all", "prepare"];
/** Commands that go along the history. */
const TRAVELS = ["undo", "redo", "travel"];
/** Commands that put something on the surface by hand, and how many of them are remembered for a restart. */
const HANDWORK = ["paint", "clear_paint", "hide_from_camera", "set_symmetry"];
const STROKES = 5000;
/** Events after which a project is another one. */
const CHANGED = ["history", "energy", "mesh", "size", "comparison"];
/** The same for cones: they are told again after the parameters, whose solution they change. */
const CONE_EDITS = ["add_cone", "move_cone", "set_cone_angle", "remove_cone"];

const nextFrame = () => new Promise((resolve) => requestAnimationFrame(resolve));

export class EngineClient {
  #on;
  #worker = null;
  #waiting = new Map();
  #nextId = 1;
  #latest = new Map();
  #deaths = 0;
  #trust = 0;
  /** The last saved project, `{ file, mesh, name }`: of which entry of the meshes it is. */
  #saved = null;
  /** The project that was there when the worker died first: what is offered when it cannot be brought back. */
  #rescued = null;
  /** The state that the status line told last. */
  #state = "";

  /** The meshes along Undo and Redo: `{ source, changes }`, a source being `{ sample }` or `{ name, bytes }`. */
  #meshes = [];
  #at = -1;
  #opening = null;
  /** The preparation under way, and who waits for its end. */
  #preparing = null;
  #rested = [];
  /** What brought the newest mesh about. */
  #made = null;
  #values = {};
  #method = null;
  /** Edits of the cones that are in force. */
  #edits = [];
  #size = null;
  /** Whether runs of a comparison go on: the document is put aside meanwhile, and a project would be that of a run. */
  #isComparing = false;
  /** Whether a document is being brought back. */
  #isReviving = false;
  /** The last time that a slider was taken hold of. */
  #hold = null;

  /**
   * @param on `events(list, spent, isReplay)`, a mesh being another one than before unless it is replayed; `scene(scene)`,
   * `restarted(sentence, hasDocument, back)`, where `back` resolves when the document is back; `failed(reason)`, `changed()` when there
   * is something new to save, `lost(name, file, isClosed)` when a document cannot be brought back as it was: `file` is its last saved project, null for none
   */
  constructor(on) {
    this.#on = on;
    this.#spawn();
    this.#trustLater();
  }

  /** Where the open mesh came from: `{ sample }` or `{ name, bytes }`. */
  get document() {
    return this.#meshes[this.#at]?.source ?? null;
  }

  /** Whether repairs or preparations have made another mesh of it. */
  get isChanged() {
    return (this.#meshes[this.#at]?.changes.length ?? 0) > 0;
  }

  /** Whether a mesh is being opened now. */
  get isOpening() {
    return this.#opening !== null;
  }

  /** Whether a tool is at work on the mesh: it ends with the mesh that it gives, before that one's first cut. */
  get isMaking() {
    return this.#preparing !== null && this.#preparing !== this.#made;
  }

  /** Sends one command; resolves when the engine has handled it. */
  command(command) {
    return this.#request({ type: "command", command }, [], command);
  }

  /**
   * Sends the newest value of a parameter: while one is on its way, and until the frame after its answer, values in
   * between are left out.
   */
  setParameter(id, value) {
    const isBusy = this.#latest.has(id);
    this.#latest.set(id, value);
    if (!isBusy) this.#sendLatest(id);
  }

  /** A slider is held. Gives what to call when it is let go: its last value goes before the engine hears of that. */
  hold() {
    const hold = (this.#hold = {});
    this.command({ type: "hold", is_held: true });
    return async () => {
      while (this.#latest.size > 0) await nextFrame();
      if (this.#hold === hold) this.command({ type: "hold", is_held: false });
    };
  }

  async #sendLatest(id) {
    const value = this.#latest.get(id);
    await this.command({ type: "set_parameter", id, value });
    if (this.#latest.get(id) !== value) await nextFrame();
    if (this.#latest.get(id) === value) this.#latest.delete(id);
    else if (this.#latest.has(id)) this.#sendLatest(id);
  }

  openSample(sample) {
    return this.#open({ sample });
  }

  openMesh(name, bytes) {
    return this.#open({ name, bytes });
  }

  async #open(source, isReplay = false) {
    this.#opening = source;
    const answer = await this.#send(source, { type: "open", source, isReplay });
    if (this.#opening === source) this.#opening = null;
    return answer;
  }

  #send(source, cause) {
    if (source.sample) {
      const command = { type: "open_sample", name: source.sample };
      return this.#request({ type: "command", command }, [], cause);
    }
    // The worker is given a copy: the page's own bytes are what a restart needs.
    const copy = source.bytes.slice().buffer;
    return this.#request({ type: "open", name: source.name, bytes: copy }, [copy], cause);
  }

  /** The file of an export item, as `file` of the answer; without one an error event has said why. */
  exportFile(kind) {
    return this.#request({ type: "export", kind });
  }

  /** Goes along the history: `changes` back (negative) or forth, past so many other meshes. */
  travel(changes, meshes) {
    return this.#request({ type: "command", command: { type: "travel", changes } }, [], { type: "travel", meshes });
  }

  /** Makes the project between two steps: `{ file, spent }`, `file` null where there is none. It is what a restart begins with. */
  async saveProject() {
    const mesh = this.#meshes[this.#at];
    if (!mesh || this.#isComparing) return { file: null, spent: 0 };
    const answer = await this.#request({ type: "save" });
    if (this.#isComparing) return { ...answer, file: null };
    // What was made of another mesh meanwhile is no use for this one.
    if (answer.file && mesh === this.#meshes[this.#at]) this.#saved = { file: answer.file, mesh, name: this.document.sample ?? this.document.name };
    return answer;
  }

  /** The last saved project of the open document, null for none. */
  get savedProject() {
    return this.#saved && this.#saved.mesh === this.#meshes[this.#at] ? this.#saved.file : null;
  }

  /** The page has taken the last scene: the next may come. */
  sceneTaken() {
    this.#worker?.postMessage({ type: "taken" });
  }

  /** Throws the worker away in the middle of its work and brings the last good document back; closes what takes too long to come back. */
  cancel(sentence) {
    if (this.#isReviving) [this.#meshes, this.#at] = [[], -1];
    this.#revive(sentence);
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
  }

  /** From when on a worker has to live for a while: once the document is back. */
  #trustLater() {
    clearTimeout(this.#trust);
    this.#trust = setTimeout(() => (this.#deaths = 0), TRUSTED_MS);
  }

  /** A worker that is killed from outside says nothing, but lets go of its lock. */
  async #watch(worker, lock) {
    try {
      await navigator.locks.request(lock, () => {});
    } catch {
      // Without locks a silent death shows only in what does not come.
      return;
    }
    if (this.#worker === worker) this.#died("it was ended from outside");
  }

  /** `cause` is the command, or `{ type: "open", source }`: what brought the events of the answer about. */
  #request(request, transfer = [], cause = null) {
    if (!this.#worker) return new Promise(() => {});
    const id = this.#nextId++;
    return new Promise((resolve) => {
      this.#waiting.set(id, { resolve, cause });
      this.#worker.postMessage({ ...request, id }, transfer);
    });
  }

  #receive(message) {
    switch (message.type) {
      case "events":
        this.#report(message.events, message.spent, this.#preparing);
        break;
      case "reply": {
        const { resolve, cause } = this.#waiting.get(message.id);
        this.#waiting.delete(message.id);
        this.#report(message.events, 0, cause);
        this.#keep(message.events, cause);
        resolve(message);
        break;
      }
      case "scene":
        this.#on.scene(message.scene);
        break;
      case "watch":
        this.#watch(this.#worker, message.lock);
        break;
      case "died":
        this.#died(message.reason);
        break;
    }
  }

  #report(events, spent, cause) {
    for (const event of events) {
      if (event.type === "parameters") this.#values = event.values;
      if (event.type === "methods") this.#method = event.current;
      if (event.type === "cones" && !event.is_edited && !event.has_placed) this.#edits = [];
      if (event.type === "size") this.#size = event;
      if (event.type === "comparison") this.#isComparing = event.progress !== null;
      if (event.type === "mesh") {
        this.#made = cause;
        this.#follow(cause);
      }
      if (event.type === "status") {
        this.#state = event.state;
        this.#rest(event.state === "preparing", cause);
      }
    }
    const isReplay = cause === null || cause.isReplay === true;
    this.#on.events(events, spent, isReplay);
    if (events.some(({ type }) => CHANGED.includes(type))) this.#on.changed();
  }

  /** Remembers what was painted. Which strokes Undo took back is the engine's knowledge: after it none are told again. */
  #keep(events, cause) {
    const mesh = this.#meshes[this.#at];
    if (!mesh || !cause || events.some(({ type }) => type === "error")) return;
    if (TRAVELS.includes(cause.type)) [mesh.handwork, this.#edits] = [[], []];
    if (CONE_EDITS.includes(cause.type)) this.#edits.push(cause);
    if (HANDWORK.includes(cause.type)) mesh.handwork = [...mesh.handwork, cause].slice(-STROKES);
  }

  /** Keeps account of which mesh is open, one entry for each that Undo and Redo pass through. */
  #follow(cause) {
    if (!cause || cause.isReplay) return;
    if (TRAVELS.includes(cause.type)) {
      const passed = { undo: -1, redo: 1 }[cause.type] ?? cause.meshes;
      this.#at = Math.min(Math.max(0, this.#at + passed), this.#meshes.length - 1);
    }
    const now = this.#meshes[this.#at];
    const made =
      cause.type === "open"
        ? { source: cause.source, changes: [], handwork: [] }
        : now && CHANGES.includes(cause.type) && { source: now.source, changes: [...now.changes, cause], handwork: [] };
    if (!made) return;
    this.#meshes.splice(this.#at + 1, Infinity, made);
    if (this.#meshes.length > KNOWN) this.#meshes.shift();
    this.#at = this.#meshes.length - 1;
  }

  /** Answers that come while a preparation goes on leave it the cause of the mesh that it will give. */
  #rest(isPreparing, cause) {
    if (isPreparing) {
      if (cause?.type === "prepare") this.#preparing = cause;
      return;
    }
    this.#preparing = null;
    for (const resolve of this.#rested.splice(0)) resolve();
  }

  #died(reason) {
    this.#deaths += 1;
    const lost = this.#opening ?? this.document;
    const name = lost?.sample ?? lost?.name;
    console.warn(`The engine stopped: ${reason}`);
    const file = this.savedProject;
    if (this.#deaths === 1) this.#rescued = file && { name: this.#saved.name, file };
    if (this.#deaths > ATTEMPTS || !lost) {
      this.#discard();
      this.#isReviving = false;
      this.#on.failed(reason);
      if (this.#rescued) this.#on.lost(this.#rescued.name, this.#rescued.file, true);
      return;
    }
    // The last attempt does without the document.
    const isGivenUp = this.#deaths === ATTEMPTS && this.#opening === null;
    this.#revive(
      this.#opening
        ? `The solver stopped while opening ${name} and was started again. ${reason}`
        : isGivenUp
          ? `The solver stopped again and again with ${name}, which was closed. ${reason}`
          : file && this.#deaths === 1
            ? `The solver stopped and was started again; ${name} comes back as it was saved last. ${reason}`
            : `The solver stopped and was started again; ${name} is back at its start. ${reason}`,
    );
    if (this.#deaths > 1 && !this.#opening) this.#on.lost(name, this.#rescued?.file ?? null, isGivenUp);
  }

  #discard() {
    this.#worker?.terminate();
    this.#worker = null;
    // Requests to a dead worker are never answered: whoever awaits them must not go on.
    this.#waiting.clear();
    this.#latest.clear();
    this.#rested = [];
    this.#opening = null;
    this.#preparing = null;
    this.#isComparing = false;
  }

  #revive(sentence) {
    let arrive;
    const back = new Promise((resolve) => (arrive = resolve));
    this.#bringBack(sentence, back).then(arrive);
  }

  async #bringBack(sentence, back) {
    // What was done to the mesh may be what kills it: the second attempt leaves that out, the third the mesh itself.
    const mesh = this.#deaths < ATTEMPTS ? this.#meshes[this.#at] : null;
    const isFirst = this.#deaths < 2;
    // A mesh that cannot be opened leaves the one before as it was saved.
    const project = isFirst ? this.savedProject : null;
    const [values, size] = [{ ...this.#values }, this.#size];
    const [method, edits] = [this.#method, this.#edits];
    this.#edits = [];
    this.#discard();
    this.#spawn();
    const worker = this.#worker;
    this.#isReviving = true;
    this.#on.restarted(sentence, mesh !== null && mesh !== undefined, back);
    await this.command({ type: "hello" });
    if (!mesh) {
      [this.#meshes, this.#at, this.#saved] = [[], -1, null];
    } else {
      // The new engine knows no way back from here.
      const back = { source: mesh.source, changes: isFirst ? mesh.changes : [], handwork: project ? mesh.handwork : [] };
      [this.#meshes, this.#at] = [[back], 0];
      if (project) {
        this.#saved = { ...this.#saved, mesh: back };
        this.#edits = edits;
        await this.#reopen(project, values);
      } else {
        this.#saved = null;
        await this.#open(mesh.source, true);
        if (method !== this.#method) await this.command({ type: "set_method", id: method });
        if (isFirst) await this.#replay(mesh, values, size, edits);
      }
    }
    this.#isReviving = false;
    if (this.#worker === worker) this.#trustLater();
  }

  /** Opens a saved project, waits until all of it was done again, and sets what was changed since. */
  async #reopen({ name, bytes }, values) {
    const copy = bytes.slice().buffer;
    await this.#request({ type: "open", name, bytes: copy }, [copy], { type: "open", isReplay: true });
    if (this.#state === "preparing") await new Promise((resolve) => this.#rested.push(resolve));
    await this.#setValues(values);
  }

  async #setValues(values) {
    for (const [id, value] of Object.entries(values)) {
      if (this.#values[id] !== value) await this.command({ type: "set_parameter", id, value });
    }
  }

  async #replay({ changes, handwork }, values, size, edits) {
    for (const command of changes) {
      await this.#request({ type: "command", command }, [], { ...command, isReplay: true });
      if (this.#preparing) await new Promise((resolve) => this.#rested.push(resolve));
    }
    // Layers first: parameters may ask for what was painted.
    for (const command of handwork) await this.command(command);
    await this.#setValues(values);
    for (const command of edits) await this.command(command);
    if (!size || !this.#size) return;
    if (this.#size.unit !== size.unit) await this.command({ type: "set_unit", id: size.unit });
    const axis = size.boxes.indexOf(Math.max(...size.boxes));
    const [was, is] = [size.boxes[axis], this.#size.boxes[axis]];
    // Sizes come back from a multiplication: what differs in the last digits is the same.
    if (Math.abs(is - was) > 1e-9 * was) await this.command({ type: "set_size", axis, value: was });
  }
}
