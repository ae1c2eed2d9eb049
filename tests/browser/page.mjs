// The page as a person meets it: by the accessible names that stay the same.

import { readFile } from "node:fs/promises";

import { PATIENCE_MS } from "./chromium.mjs";

export class Page {
  constructor(page) {
    this.page = page;
  }

  /** Goes to an address and waits until the status line has left `Loading`. */
  async visit(address) {
    await this.page.goto(address);
    return this.status(/^(Ready|Running|Paused|Converged)/);
  }

  /** Waits for a status line; gives the match. */
  async status(pattern) {
    const line = this.page.getByRole("status");
    const end = Date.now() + PATIENCE_MS;
    let text = "";
    while (Date.now() < end) {
      text = (await line.textContent()).trim();
      const match = pattern.exec(text);
      if (match) return match;
      await this.page.waitForTimeout(20);
    }
    throw new Error(`the status line says “${text}” and never ${pattern}`);
  }

  press(name) {
    return this.page.getByRole("button", { name, exact: true }).click();
  }

  /** A click that does not wait for two frames to see that the button stands still: software graphics are slow to draw. */
  pressAtOnce(name) {
    return this.page.getByRole("button", { name, exact: true }).evaluate((button) => button.click());
  }

  canvas(label) {
    return this.page.getByLabel(label, { exact: true });
  }

  /** Chooses a file, given by name and text, through the file input. */
  async chooseFile(name, text) {
    const file = { name, mimeType: "text/plain", buffer: Buffer.from(text) };
    await this.page.getByLabel("Open mesh", { exact: true }).setInputFiles(file);
  }

  /** Drops a file on the page, as from a file manager. */
  async dropFile(name, text) {
    const transfer = await this.page.evaluateHandle(
      ({ name, text }) => {
        const transfer = new DataTransfer();
        transfer.items.add(new File([text], name));
        return transfer;
      },
      { name, text },
    );
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

  /** The paragraphs of the error that is shown. */
  async error() {
    const alert = this.page.getByRole("alert");
    await alert.waitFor({ state: "visible" });
    const paragraphs = await alert.locator("p").allTextContents();
    return paragraphs.map((text) => text.trim()).filter(Boolean);
  }
}
