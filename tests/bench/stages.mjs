// The stages of each method in wasm, by the script of `stages.rs`: for Node and for browsers alike.

/** Steps that are timed of runs that would go on, and the size beyond which whole runs are left out: as in `stages.rs`. */
const STEPS = 30;
const LARGE = 50_000;

function check(events) {
  const error = events.find(({ type }) => type === "error");
  if (error) throw new Error(`${error.what} ${error.where}`);
  return events;
}

/** The ball of the page, some steps into its run: the middle of three rounds, as the first still meets code that is being compiled. */
function ball(Engine, clock) {
  const engine = new Engine();
  engine.warm_up();
  engine.handle({ type: "open_sample", name: "ball" });
  const steps = (events) => events.filter(({ type }) => type === "energy").length;
  const advance = (count) => {
    let done = 0;
    while (done < count && engine.is_running()) done += steps(engine.advance(0));
    return done;
  };
  const rounds = [];
  for (let round = 0; round < 3; round++) {
    engine.handle({ type: "reset" });
    engine.handle({ type: "run" });
    advance(10);
    const start = clock();
    const done = advance(20);
    rounds.push((clock() - start) / done);
  }
  engine.free();
  return rounds.sort((a, b) => a - b)[1];
}

function script(Engine, clock, bytes, isLarge) {
  const engine = new Engine();
  const rows = [];
  const timed = (name, work) => {
    const start = clock();
    const count = work() ?? 1;
    rows.push([name, (clock() - start) / count]);
  };
  const send = (command) => check(engine.handle(command));
  const advance = (most) => {
    let done = 0;
    while (done < most && engine.is_running()) {
      check(engine.advance(0));
      done++;
    }
    return Math.max(done, 1);
  };
  const rest = () => void advance(Infinity);
  timed("load", () => {
    check(engine.open("bumpy.obj", bytes));
    rest();
    engine.scene();
  });
  send({ type: "run" });
  timed("cut flow, a step", () => advance(STEPS));
  send({ type: "pause" });
  timed("flatten and UV mesh", () => void engine.export_file("UV mesh (OBJ)"));
  timed("pattern", () => void engine.export_file("Pattern (SVG)"));
  send({ type: "set_method", id: "phasefield" });
  send({ type: "run" });
  timed("phase field, an iteration", () => advance(STEPS));
  send({ type: "pause" });
  if (!isLarge) {
    for (const [name, id] of [
      ["cones, the whole solution", "cones"],
      ["developable patches, the whole run", "developable"],
    ]) {
      send({ type: "set_method", id });
      send({ type: "run" });
      timed(name, rest);
    }
  }
  engine.free();
  return rows;
}

/**
 * @param pkg what `engine.js` exports, ready for use, with its `memory`
 * @param clock gives milliseconds
 * @param meshes `[vertices, bytes]` of each
 * @return `[name, milliseconds or megabytes]` of each row
 */
export function measure({ Engine, memory }, clock, meshes) {
  const rows = [["session step, ball", ball(Engine, clock)]];
  // Once for the compiler, on the smallest mesh.
  script(Engine, clock, meshes[0][1], false);
  for (const [vertices, bytes] of meshes) {
    for (const [name, time] of script(Engine, clock, bytes, vertices > LARGE)) {
      rows.push([`${name}, ${vertices} vertices`, time]);
    }
    rows.push([`memory after ${vertices} vertices`, memory.buffer.byteLength / 1e6]);
  }
  return rows;
}
