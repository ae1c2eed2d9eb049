// Time of a session step in wasm, by the same script as the native benchmark: node engine.mjs → one number, milliseconds.

import { readFile } from "node:fs/promises";

const pkg = new URL("../../www/pkg/", import.meta.url);
const { initSync, Engine } = await import(new URL("engine.js", pkg));
initSync({ module: await readFile(new URL("engine_bg.wasm", pkg)) });

const engine = new Engine();
engine.warm_up();
engine.handle({ type: "open_sample", name: "ball" });

const steps = (events) => events.filter((event) => event.type === "energy").length;
const advance = (count) => {
  let done = 0;
  while (done < count && engine.is_running()) done += steps(engine.advance(0));
  return done;
};
// Three rounds, the middle one counts: the first still meets code that is being compiled.
const rounds = [];
for (let round = 0; round < 3; round++) {
  engine.handle({ type: "reset" });
  engine.handle({ type: "run" });
  advance(10);
  const start = performance.now();
  const done = advance(20);
  rounds.push((performance.now() - start) / done);
}
rounds.sort((a, b) => a - b);
console.log(rounds[1].toFixed(3));
