// The page as a person meets it: by the accessible names that stay the same.

import { readFile } from "node:fs/promises";

import { COARSE, PAGE, PATIENCE_MS, open } from "./chromium.mjs";

/**
 * A browser with the page in it, at rest: `{ browser, page, tab }`. With a `mesh` that one is open, and no sample was before it; `script`
 * runs in the page before its own. Tests that compare pictures ask for all `pixels`.
 */
export async function begin(renderer, { query = "run=0", name = "mesh.obj", mesh = null, script = null, pixels = COARSE, ready } = {}) {
  const browser = await open(renderer, pixels);
  const page = new Page(browser.page);
  if (script) await page.page.addInitScript(script);
  await page.visit(`${PAGE}?renderer=${renderer.query}&${mesh ? "sample=none&" : ""}${query}`);
  await page.page.waitForSelector("html[data-renderer]", { state: "attached" });
  if (await page.page.locator("html").getAttribute("data-renderer") !== renderer.name) throw new Error(`the page is not drawn with ${renderer.name}`);
  if (mesh) await page.bring(name, mesh, ready);
  return { browser, page, tab: page.page };
}

export class Page {
  constructor(page) {
    this.page = page;
  }

  /** Goes to an address and waits until the status line has left `Loading`. */
  async visit(address) {
    await this.page.goto(address);
    return this.status(/^(Ready|Running|Paused|Converged)/);
  }

  /** Waits for a status line; gives the match. The page itself watches: a state that soon passes is not missed. */
  async status(pattern, patience = PATIENCE_MS) {
    await this.page.getByRole("status").waitFor({ state: "attached" });
    const { match, text } = await this.page.evaluate(watchStatus, { source: pattern.source, flags: pattern.flags, patience });
    if (match) return match;
    throw new Error(`the status line says “${text}” and never ${pattern}`);
  }

  press(name) {
    return this.page.getByRole("button", { name, exact: true }).click();
  }

  /** A click that does not wait for two frames to see that the button stands still: software graphics are slow to draw. */
  pressAtOnce(name) {
    return this.page.getByRole("button", { name, exact: true }).evaluate((button) => button.click());
  }

  /** Runs, and pauses once the status line says something. The page itself presses both: a small mesh is cut before word of it is here and back. */
  async runUntil(pattern) {
    const [first, then] = await Promise.all(["Run", "Pause"].map((name) => this.page.getByRole("button", { name, exact: true }).elementHandle()));
    const { match, text } = await this.page.evaluate(watchStatus, { source: pattern.source, flags: pattern.flags, patience: PATIENCE_MS, first, then });
    if (!match) throw new Error(`the status line says “${text}” and never ${pattern}`);
  }

  canvas(label) {
    return this.page.getByLabel(label, { exact: true });
  }

  /** Chooses a file, given by name and content (text or bytes), through the file input. */
  async chooseFile(name, content) {
    const file = { name, mimeType: "application/octet-stream", buffer: Buffer.from(content) };
    await this.page.getByLabel("Open mesh", { exact: true }).setInputFiles(file);
  }

  /** Drops a mesh on the page, and waits until it is open and ready: cones are solved at once. */
  async bring(name, content, ready = /^Ready$/) {
    await this.dropFile(name, content);
    await this.until(`${name} is open`, () => this.page.title(), (title) => title.endsWith(name));
    await this.status(ready);
  }

  /** Waits for frames after which whatever was asked for is drawn: the newest scene may take one or two to reach the canvas. */
  drawn() {
    return this.page.evaluate(async () => {
      for (let i = 0; i < 4; i += 1) await new Promise((done) => requestAnimationFrame(done));
    });
  }

  /** Drops a file on the page, as from a file manager. */
  dropFile(name, content) {
    return this.dropFiles({ [name]: content });
  }

  /** Drops several files at once: contents by name, in this order. */
  async dropFiles(contents) {
    const files = Object.entries(contents).map(([name, content]) => [name, Buffer.from(content).toString("base64")]);
    const transfer = await this.page.evaluateHandle((files) => {
      const transfer = new DataTransfer();
      for (const [name, code] of files) {
        const bytes = Uint8Array.from(atob(code), (letter) => letter.charCodeAt(0));
        transfer.items.add(new File([bytes], name));
      }
      return transfer;
    }, files);
    for (const type of ["dragenter", "dragover", "drop"]) {
      await this.page.dispatchEvent("body", type, { dataTransfer: transfer });
    }
  }

  /** The text of what an item of the Export menu downloads. */
  async export(item) {
    const bytes = await this.exportBytes(item);
    return bytes.toString("utf8");
  }

  async exportBytes(item) {
    const [download] = await Promise.all([
      this.page.waitForEvent("download"),
      this.press("Export").then(() => this.page.getByRole("menuitem", { name: item, exact: true }).click()),
    ]);
    return readFile(await download.path());
  }

  /** The first number in a row of the Measures table. */
  async measure(label) {
    const row = this.page.getByRole("table", { name: "Measures" }).getByRole("row").filter({
      has: this.page.getByRole("rowheader", { name: label, exact: true }),
    });
    return Number.parseFloat((await row.getByRole("cell").first().textContent()).replace("−", "-"));
  }

  /** The Mesh section, or a part of it: `Size`, `Doctor`, `Prepare`. */
  meshSection(part) {
    const section = this.page.getByRole("group", { name: "Mesh", exact: true });
    return part ? section.getByRole("group", { name: part, exact: true }) : section;
  }

  /** Opens the Mesh section where it is closed. */
  async openMeshSection() {
    const isOpen = await this.meshSection().evaluate((section) => section.open);
    if (!isOpen) await this.meshSection().locator("summary").first().click();
  }

  /** `{ vertices, faces }` as the head of the Mesh section says. */
  async counts() {
    const text = await this.meshSection().locator("summary").first().textContent();
    const number = (noun) => Number(new RegExp(`([\\d\u202f]+) ${noun}`).exec(text)?.[1].replaceAll("\u202f", ""));
    return { vertices: number("vert"), faces: number("face") };
  }

  /** Lets the solver say of itself what it says after a panic, and waits for the one that takes its place. */
  async endSolver() {
    const [worker] = this.page.workers();
    // The page may end it before it has answered here.
    await worker.evaluate(() => self.postMessage({ type: "died", reason: "a test" })).catch(() => {});
    await this.until("a new solver", () => this.page.workers()[0], (now) => now && now !== worker);
  }

  /** Waits until `answer()` says what is wanted, and gives it. */
  async until(what, answer, isWanted) {
    const end = Date.now() + PATIENCE_MS;
    let value;
    do {
      value = await answer();
      if (isWanted(value)) return value;
      await this.page.waitForTimeout(20);
    } while (Date.now() < end);
    throw new Error(`${what}: ${JSON.stringify(value)}`);
  }

  /** The numbers in the boxes of the size: width, height and depth. */
  sizes() {
    const value = (label) => this.meshSection("Size").getByLabel(label, { exact: true }).inputValue();
    return Promise.all(["Width (x)", "Height (y)", "Depth (z)"].map(async (label) => Number((await value(label)).replace("\u202f", ""))));
  }

  /** The paragraphs of the error that is shown. */
  async error() {
    const alert = this.page.getByRole("alert");
    await alert.waitFor({ state: "visible" });
    const paragraphs = await alert.locator("p").allTextContents();
    return paragraphs.map((text) => text.trim()).filter(Boolean);
  }
}

/** Runs in the page: gives the first status line that matches, or what it says when patience ends. */
function watchStatus({ source, flags, patience, first = null, then = null }) {
  const line = document.querySelector("[role=status]");
  const pattern = new RegExp(source, flags);
  return new Promise((resolve) => {
    const observer = new MutationObserver(look);
    const late = setTimeout(() => end(null), patience);
    function end(match) {
      observer.disconnect();
      clearTimeout(late);
      resolve({ match: match && [...match], text: line.textContent.trim() });
    }
    function look() {
      const match = pattern.exec(line.textContent.trim());
      if (!match) return;
      then?.click();
      end(match);
    }
    observer.observe(line, { childList: true, characterData: true, subtree: true });
    first?.click();
    look();
  });
}
