// Starts Chromium with one of the two graphics backends, and listens for what goes wrong in it.

import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { chromium } from "playwright-core";

/** Solvers, software graphics and whatever else the machine does share a core or two here. */
export const PATIENCE_MS = 60_000;

/** What a software WebGPU with visible canvases takes; any other combination has a device and draws nothing. */
const WEBGPU = [
  "--enable-unsafe-webgpu",
  "--use-webgpu-adapter=swiftshader",
  "--enable-features=Vulkan",
  "--use-vulkan=swiftshader",
  "--use-angle=swiftshader",
];

/** The backends: what the address asks for, what the page then says, and the browser's flags. */
export const RENDERERS = [
  { query: "webgl", name: "webgl2", flags: [] },
  { query: "webgpu", name: "webgpu", flags: WEBGPU },
];

export const PAGE = needed("CUTFLOW_URL");
export const PACKED_PAGE = needed("CUTFLOW_PACKED_URL");
const SCREENSHOTS = needed("CUTFLOW_SCREENSHOTS");

/** Half the pixels each way, for tests that compare no pictures: software graphics draw those four times as fast. */
export const COARSE = 0.5;

/** A browser with one empty page, `{ page, troubles, close }`; `troubles` fills with what the page complains of. */
export async function open(renderer, deviceScaleFactor = 1) {
  const browser = await chromium.launch({
    executablePath: needed("CHROMIUM"),
    args: [...needed("CHROMIUM_FLAGS").split(" "), ...renderer.flags],
    headless: true,
  });
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, deviceScaleFactor, reducedMotion: "reduce", colorScheme: "light" });
  page.setDefaultTimeout(PATIENCE_MS);
  const troubles = [];
  page.on("console", (message) => message.type() === "error" && troubles.push(message.text()));
  page.on("pageerror", (error) => troubles.push(error.stack ?? String(error)));
  page.on("crash", () => troubles.push("the page crashed"));
  page.on("response", (response) => response.status() >= 400 && troubles.push(`${response.status()} ${response.url()}`));
  return { page, troubles, close: () => browser.close() };
}

/** Keeps a picture of the whole page for people to look at. */
export async function screenshot(page, name) {
  mkdirSync(SCREENSHOTS, { recursive: true });
  await page.screenshot({ path: join(SCREENSHOTS, `${name}.png`) });
}

function needed(variable) {
  const value = process.env[variable];
  if (value === undefined) throw new Error(`${variable} is not set: start the tests with \`cargo xtask test --browser\``);
  return value;
}
