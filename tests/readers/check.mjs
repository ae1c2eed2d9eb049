// Looks at exported files with readers that are npm packages, and with a browser: `cargo xtask test --readers` starts it.
//
//     node check.mjs FOLDER
//
// gltf-validator finds nothing to complain of in a GLB; dxf-parser, of the family that loops for ever on a line without end, reads
// a DXF; Chromium shows an SVG in real size. Each file is read by a process of its own that is stopped after a while.

import { spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

/** For one file. Reading takes far less; a browser starts in a few seconds. */
const LIMIT_MS = 60_000;

/** CSS pixels of a millimetre. */
const PIXELS = 96 / 25.4;

/** CSS pixels: sizes of the outermost element snap to 1/64, and the square is a fraction of it. */
const SNAP = 0.02;

const READERS = { ".glb": readGlb, ".dxf": readDxf, ".svg": readSvg };

async function readGlb(path) {
  const { default: validator } = await import("gltf-validator");
  const { issues, info } = await validator.validateBytes(new Uint8Array(readFileSync(path)));
  const { numErrors, numWarnings, numInfos, numHints } = issues;
  const text = issues.messages.map(({ code, message, pointer }) => `${code} ${message} ${pointer}`).join("\n");
  hold(numErrors + numWarnings + numInfos + numHints === 0, `gltf-validator reports nothing${text && `\n${text}`}`);
  hold(info.totalTriangleCount > 0, `it counts triangles: ${info.totalTriangleCount}`);
}

async function readDxf(path) {
  const { default: DxfParser } = await import("dxf-parser");
  const { entities, blocks } = new DxfParser().parseSync(readFileSync(path, "latin1"));
  const all = [...entities, ...Object.values(blocks ?? {}).flatMap((block) => block.entities ?? [])];
  hold(entities.length > 0, `dxf-parser reads ${entities.length} entities`);
  const outlines = all.filter(({ type, layer }) => type === "POLYLINE" && (layer === "CUT" || layer === "1"));
  hold(outlines.length > 0 && outlines.every(({ shape }) => shape), `its ${outlines.length} outlines are closed`);
  const numbers = all.flatMap(({ vertices = [] }) => vertices.flatMap(({ x, y }) => [x, y]));
  hold(numbers.length > 0 && numbers.every(Number.isFinite), "all their coordinates are numbers");
}

async function readSvg(path) {
  const require = createRequire(new URL("../browser/package.json", import.meta.url));
  const { chromium } = require("playwright-core");
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM,
    args: (process.env.CHROMIUM_FLAGS ?? "").split(" ").filter(Boolean),
  });
  try {
    const page = await browser.newPage();
    await page.goto(pathToFileURL(path).href);
    const found = await page.evaluate(() => {
      const size = (element) => {
        const { width, height } = element.getBoundingClientRect();
        return [width, height];
      };
      const square = document.getElementById("control-square");
      const root = document.documentElement;
      return { square: square && size(square), root: size(root), width: root.getAttribute("width"), height: root.getAttribute("height") };
    });
    const off = (pixels, mm) => Math.abs(pixels - mm * PIXELS);
    // Rounded to 1/64 of a pixel and cut to what a layout counts in.
    hold(off(found.root[0], parseFloat(found.width)) < SNAP && off(found.root[1], parseFloat(found.height)) < SNAP, "Chromium shows the sheet in real size");
    // A laser has no use for a square that it would cut.
    if (found.square === null) hold(/laser/.test(path), "only files for lasers are without control square");
    else hold(found.square.every((side) => off(side, 50) < SNAP), `its control square measures 50 mm (${found.square.map((side) => (side / PIXELS).toFixed(4))})`);
  } finally {
    await browser.close();
  }
}

function hold(isTrue, sentence) {
  if (!isTrue) {
    console.log(`  FAILED  ${sentence}`);
    process.exit(1);
  }
  console.log(`  ok  ${sentence}`);
}

/** The files on the list that one of the readers is for. */
function wanted() {
  const list = JSON.parse(readFileSync(join(import.meta.dirname, "files.json"), "utf8"));
  return Object.entries(list).flatMap(([folder, files]) => files.map((file) => `${folder}/${file}`)).filter(readerOf).sort();
}

function readerOf(name) {
  return READERS[name.slice(name.lastIndexOf("."))];
}

function main(folder) {
  const failures = [];
  for (const name of wanted()) {
    console.log(name);
    const child = spawnSync(process.execPath, [fileURLToPath(import.meta.url), "--file", join(folder, name)], { timeout: LIMIT_MS, killSignal: "SIGKILL", stdio: "inherit" });
    if (child.status !== 0) failures.push(`${name}: ${child.error?.code === "ETIMEDOUT" ? `no answer within ${LIMIT_MS / 1000} s` : "see above"}`);
  }
  for (const failure of failures) console.log(`FAILED  ${failure}`);
  console.log(`${wanted().length} files, ${failures.length} failures`);
  process.exitCode = failures.length > 0 ? 1 : 0;
}

if (process.argv[2] === "--file") await readerOf(process.argv[3])(process.argv[3]);
else main(process.argv[2]);
