// Times of the engine in wasm: node engine.mjs FOLDER [CHROMIUM FLAG…] → rows as JSON. With the path of a browser they are measured in it.

import { createServer } from "node:http";
import { readFile, readdir } from "node:fs/promises";
import { join, normalize } from "node:path";

import { measure } from "./stages.mjs";

const root = new URL("../../", import.meta.url);
const [folder, chromium, ...flags] = process.argv.slice(2);
const sizes = (await readdir(folder))
  .map((name) => Number(/^bumpy-(\d+)\.obj$/.exec(name)?.[1]))
  .filter(Number.isInteger)
  .sort((a, b) => a - b);
const file = (vertices) => join(folder, `bumpy-${vertices}.obj`);

async function inNode() {
  const pkg = new URL("www/pkg/", root);
  const engine = await import(new URL("engine.js", pkg));
  const { memory } = engine.initSync({ module: await readFile(new URL("engine_bg.wasm", pkg)) });
  const meshes = await Promise.all(sizes.map(async (n) => [n, await readFile(file(n))]));
  // Processor time: on a busy machine the wall's clock counts the work of others.
  const clock = () => {
    const { user, system } = process.cpuUsage();
    return (user + system) / 1000;
  };
  return measure({ Engine: engine.Engine, memory }, clock, meshes);
}

const TYPES = { ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm" };

/** Serves the engine, the script and the meshes to the browser, and nothing else. */
async function serve() {
  const places = [
    [/^\/(www\/pkg\/engine[\w.]*)$/, (path) => new URL(path, root)],
    [/^\/(stages\.mjs)$/, (path) => new URL(path, import.meta.url)],
    [/^\/(bumpy-\d+\.obj)$/, (path) => join(folder, path)],
  ];
  const server = createServer(async ({ url }, answer) => {
    if (url === "/") return answer.writeHead(200, { "Content-Type": "text/html" }).end("<!doctype html><title>Figures</title>");
    for (const [pattern, place] of places) {
      const path = pattern.exec(normalize(url))?.[1];
      if (!path) continue;
      const type = TYPES[/\.\w+$/.exec(path)[0]] ?? "text/plain";
      return answer.writeHead(200, { "Content-Type": type }).end(await readFile(place(path)));
    }
    return answer.writeHead(404).end();
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return server;
}

async function inBrowser() {
  const { chromium: driver } = await import(new URL("tests/browser/node_modules/playwright-core/index.mjs", root));
  const server = await serve();
  const browser = await driver.launch({ executablePath: chromium, args: flags });
  try {
    const page = await browser.newPage();
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    return await page.evaluate(async (sizes) => {
      const engine = await import("/www/pkg/engine.js");
      const { measure } = await import("/stages.mjs");
      const { memory } = await engine.default();
      const bytes = async (n) => new Uint8Array(await (await fetch(`/bumpy-${n}.obj`)).arrayBuffer());
      const meshes = [];
      for (const n of sizes) meshes.push([n, await bytes(n)]);
      return measure({ Engine: engine.Engine, memory }, () => performance.now(), meshes);
    }, sizes);
  } finally {
    await browser.close();
    server.close();
  }
}

console.log(JSON.stringify(await (chromium ? inBrowser() : inNode())));
