// Runs every test file beside it, one after the other, in one process: two browsers at once would only wait for each
// other. `cargo xtask test --browser` starts it, with the addresses and the browser in the environment.

import { readdirSync } from "node:fs";

for (const file of readdirSync(import.meta.dirname).filter((name) => name.endsWith(".test.mjs")).sort()) {
  await import(`./${file}`);
}
