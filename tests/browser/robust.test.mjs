// What goes wrong around the page: tabs and workers that die, graphics that are lost, storage that is denied or full, browsers
// that lack something, meshes that no memory holds. And what brings a setting back: history, sessions, links.

import assert from "node:assert/strict";
import { after, before, describe, it } from "node:test";

import { COARSE, PAGE, RENDERERS, open, screenshot } from "./chromium.mjs";
import { ellipsoid } from "./meshes.mjs";
import { Page } from "./page.mjs";
import { decodePng, difference, variety } from "./pixels.mjs";
import { records, visitors } from "./visitors.mjs";

const [, WEBGPU] = RENDERERS;
const AT_REST = `${PAGE}?renderer=webgl&run=0`;
/** Without a sample, for tests that bring a mesh. */
const EMPTY = `${AT_REST}&sample=none`;
const SMALL = ellipsoid(3);

/** Lets a test end the workers of a page, as a browser that is short of memory does: without a word to anybody. */
function recordWorkers() {
  const workers = [];
  const Original = Worker;
  window.Worker = class extends Original {
    constructor(...given) {
      super(...given);
      workers.push(this);
      this.addEventListener("message", ({ data }) => data.type === "watch" && setTimeout(() => dispatchEvent(new Event("worker lives"))));
    }
  };
  let left = 0;
  const end = () => {
    left -= 1;
    workers.at(-1).terminate();
  };
  // A worker says when its death can be noticed.
  addEventListener("worker lives", () => left > 0 && end());
  addEventListener("end workers", ({ detail }) => {
    left = detail;
    end();
  });
}
/** Ends the worker, and so many in all as soon as they live. */
const endWorkers = (page, count = 1) => page.evaluate((detail) => dispatchEvent(new CustomEvent("end workers", { detail })), count);

describe("robust page", { timeout: 900_000 }, () => {
  const { visitor, tab, leave } = visitors();

  const restoreButton = (page) => page.page.getByRole("button", { name: "Restore last session" });

  describe("history", () => {
    let page;
    before(async () => {
      page = await tab(await visitor());
      await page.visit(EMPTY);
      await page.bring("mine.obj", SMALL);
    });
    after(leave);

    it("lists what was done by name, and goes to any point of it by keyboard", async () => {
      for (const step of [1, 2, 3]) {
        await page.press("Step");
        await page.status(new RegExp(`^Paused at step ${step}$`));
      }
      await page.press("History");
      const items = page.page.getByRole("group", { name: "History", exact: true }).getByRole("listitem");
      const names = await items.allTextContents();
      assert.equal(names[0], "Start");
      assert.equal(names.length, 4);
      assert.equal(await items.nth(3).getAttribute("aria-current"), "step");
      await page.page.keyboard.press("ArrowUp");
      await page.page.keyboard.press("ArrowUp");
      await page.page.keyboard.press("Enter");
      await page.status(/^Paused at step 1$/);
      assert.equal(await page.page.getByRole("button", { name: "History" }).getAttribute("aria-expanded"), "false");
    });

    it("goes forth again by a click, several changes at once", async () => {
      await page.press("History");
      const items = page.page.getByRole("group", { name: "History", exact: true }).getByRole("listitem");
      assert.equal(await items.nth(1).getAttribute("aria-current"), "step");
      await items.nth(3).getByRole("button").click();
      await page.status(/^Paused at step 3$/);
      assert.equal(await page.page.getByRole("button", { name: "Redo", exact: true }).isDisabled(), true);
      assert.deepEqual(page.troubles, []);
    });
  });

  describe("sessions", () => {
    after(leave);

    it("come back after the tab was killed: mesh, parameters and cut", async () => {
      const context = await visitor();
      const page = await tab(context);
      await page.visit(EMPTY);
      await page.bring("mine.obj", SMALL);
      const offset = page.page.getByRole("textbox", { name: /length/i }).first();
      await offset.fill("2.5");
      await offset.press("Enter");
      for (const step of [1, 2]) {
        await page.press("Step");
        await page.status(new RegExp(`^(Paused|Converged).* ${step}( steps)?$`));
      }
      const cut = await page.export("Cut (JSON)");
      await page.until("the session is kept", () => records(page), (all) => all[0]?.about.endsWith("step 2"));
      // No farewell: `close` without `runBeforeUnload` is what a killed tab looks like to the next visit.
      await page.page.close({ runBeforeUnload: false });

      const next = await tab(context);
      await next.page.goto(`${PAGE}?renderer=webgl`);
      await restoreButton(next).waitFor();
      assert.match(await next.page.getByRole("group", { name: "Last session" }).textContent(), /mine\.obj.*step 2.*(now|ago)/);
      // Beside the sample that runs, and not over everything.
      await next.status(/^(Running|Converged)/);
      await screenshot(next.page, "restore-offer");
      await restoreButton(next).click();
      await next.page.waitForFunction(() => document.title.includes("mine.obj"));
      await next.status(/^(Paused|Converged).* 2( steps)?$/);
      assert.equal(await next.export("Cut (JSON)"), cut);
      assert.equal(await next.page.getByRole("textbox", { name: /length/i }).first().inputValue(), "2.50");
      assert.deepEqual(next.troubles, []);
    });

    it("are not kept before somebody has done something", async () => {
      const page = await tab(await visitor());
      await page.visit(`${PAGE}?renderer=webgl`);
      await page.status(/^(Running step ([2-9]|\d\d)|Converged)/);
      await page.pressAtOnce("Pause");
      await page.status(/^(Paused|Converged)/);
      // Twice as long as what is done by hand takes to be kept.
      await page.page.waitForTimeout(2000);
      assert.deepEqual(await records(page), []);
    });

    it("that are broken are dropped with a word", async () => {
      const context = await visitor();
      const page = await tab(context);
      await page.visit(EMPTY);
      await records(page);
      await page.page.evaluate(
        () =>
          new Promise((resolve) => {
            const request = indexedDB.open("cutflow", 1);
            request.onsuccess = () => {
              const bytes = new TextEncoder().encode('{"cutflow_project": 1, "mesh": {');
              const transaction = request.result.transaction("sessions", "readwrite");
              transaction.objectStore("sessions").put({ key: "old", name: "broken.obj", when: Date.now(), about: "", bytes });
              transaction.oncomplete = resolve;
            };
          }),
      );
      await page.visit(AT_REST);
      await restoreButton(page).click();
      const [what] = await page.error();
      assert.match(what, /project/);
      await page.page.getByText("The last session could not be read and was dropped.").waitFor();
      await page.until("the record is gone", () => records(page), (all) => all.length === 0);
      // The sample is still there.
      assert.ok((await page.measure("Pieces")) >= 1);
      assert.deepEqual(page.troubles, []);
    });

    it("cannot be kept where storage is denied: the page says so and works", async () => {
      const page = await tab(
        await visitor({}, () => {
          const denied = () => {
            throw new DOMException("denied", "SecurityError");
          };
          for (const name of ["indexedDB", "localStorage", "caches"]) Object.defineProperty(window, name, { get: denied });
        }),
      );
      await page.visit(EMPTY);
      await page.bring("mine.obj", SMALL);
      await page.press("Step");
      await page.status(/^Paused at step 1$/);
      await page.page.getByText(/This browser keeps no data of this page/).waitFor();
      await page.press("Theme");
      assert.deepEqual(page.troubles, []);
    });

    it("cannot be kept where storage is full: the page says so and works", async () => {
      const page = await tab(
        await visitor({}, () => {
          IDBObjectStore.prototype.put = () => {
            throw new DOMException("full", "QuotaExceededError");
          };
        }),
      );
      await page.visit(EMPTY);
      await page.bring("mine.obj", SMALL);
      await page.press("Step");
      await page.page.getByText(/There is no room left to keep the session/).waitFor();
      await page.press("Step");
      await page.status(/^Paused at step 2$/);
      assert.deepEqual(page.troubles, []);
    });
  });

  describe("a worker that dies", () => {
    let page;
    before(async () => {
      page = await tab(await visitor({}, recordWorkers));
      await page.visit(EMPTY);
      await page.bring("mine.obj", SMALL);
    });
    after(leave);

    it("gives the document back as it was saved last", async () => {
      await page.press("Step");
      await page.status(/^Paused at step 1$/);
      const cut = await page.export("Cut (JSON)");
      await page.until("the session is kept", () => records(page), (all) => all[0]?.about.endsWith("step 1"));
      await endWorkers(page.page);
      await page.page.getByText(/comes back as it was saved last/).waitFor();
      await page.status(/^Paused at step 1$/);
      assert.equal(await page.export("Cut (JSON)"), cut);
    });

    it("in the middle of a run loses no more than the time since", async () => {
      // Trust comes back only with time; another page is faster.
      const other = await tab(await visitor({}, recordWorkers));
      await other.visit(EMPTY);
      await other.bring("mine.obj", ellipsoid(4));
      const running = other.status(/^Running step ([3-9]|\d\d)/);
      await other.pressAtOnce("Run");
      await running;
      await endWorkers(other.page);
      await other.page.getByText(/The solver stopped and was started again/).waitFor();
      await other.status(/^(Paused|Ready|Converged)/);
      await other.press("Step");
      await other.status(/^(Paused at step|Converged)/);
      assert.deepEqual(other.troubles, []);
    });

    it("again and again is given up, and the project is offered", async () => {
      // A visitor of its own: a worker that lived for a while after its death would count from one again.
      page = await tab(await visitor({}, recordWorkers));
      await page.visit(EMPTY);
      await page.bring("mine.obj", SMALL);
      await page.press("Step");
      await page.until("the session is kept", () => records(page), (all) => all[0]?.about.endsWith("step 1"));
      await endWorkers(page.page, 3);
      await page.page.getByText("mine.obj makes the solver stop, so it was closed.").waitFor();
      await page.status(/^Ready: open a mesh or choose a sample/);
      const [download] = await Promise.all([page.page.waitForEvent("download"), page.press("Download its project")]);
      assert.equal(download.suggestedFilename(), "mine-project.json");
      // The page goes on with something else.
      await page.page.getByLabel("Sample", { exact: true }).selectOption("ball");
      await page.page.waitForFunction(() => document.title.includes("Ball"));
      await page.status(/^Ready$/);
      assert.deepEqual(page.troubles, []);
    });
  });

  describe("graphics", () => {
    after(leave);

    it("that are lost during a run are made again, seen from the same side", async () => {
      const page = await tab(await visitor());
      await page.visit(AT_REST);
      const canvas = page.canvas("Surface view");
      await canvas.focus();
      for (let i = 0; i < 8; i += 1) await page.page.keyboard.press("ArrowRight");
      for (let i = 0; i < 3; i += 1) await page.page.keyboard.press("+");
      await page.press("Run");
      await page.status(/^Running step [1-9]/);
      await page.page.evaluate(() => {
        for (const canvas of document.querySelectorAll("canvas[role=img]")) {
          canvas.dataset.lost = "";
          canvas.getContext("webgl2").getExtension("WEBGL_lose_context").loseContext();
        }
      });
      await page.page.waitForFunction(() => document.querySelectorAll("canvas[role=img]:not([data-lost])").length === 2);
      await page.pressAtOnce("Pause");
      await page.status(/^(Paused|Converged)/);
      await page.drawn();
      const again = decodePng(await canvas.screenshot());
      assert.ok(variety(again).covered > 0.1, "the surface is drawn again");
      // The same view of another page is the measure.
      await page.press("Share");
      const link = await page.page.getByLabel("Link to this setting").inputValue();
      assert.match(link, /view=/);
      await page.page.keyboard.press("Escape");
      await page.press("Fit surface");
      await page.drawn();
      const fitted = decodePng(await canvas.screenshot());
      assert.ok(difference(again, fitted) > 1, "it was nearer than all of it");
      assert.deepEqual(page.troubles, []);
    });

    it("that are lost keep what was pinned, in both views", async () => {
      const page = await tab(await visitor());
      await page.visit(EMPTY);
      await page.bring("mine.obj", SMALL);
      await page.page.getByLabel("Surface overlay", { exact: true }).selectOption("u");
      await page.until("the field", () => page.page.locator(".surface .legend .title").count(), (count) => count === 1);
      const box = await page.canvas("Surface view").boundingBox();
      const pins = page.page.getByRole("button", { name: /^Pinned/ });
      const said = () => pins.evaluateAll((list) => list.map((pin) => [pin.textContent, pin.getBoundingClientRect().x, pin.getBoundingClientRect().y]));
      await page.page.mouse.click(box.x + 0.5 * box.width, box.y + 0.45 * box.height);
      await page.until("pins", () => pins.count(), (count) => count === 2);
      await page.page.keyboard.press("ArrowLeft");
      await page.drawn();
      const before = await said();
      await page.page.evaluate(() => {
        for (const canvas of document.querySelectorAll("canvas[role=img]")) {
          canvas.dataset.lost = "";
          canvas.getContext("webgl2").getExtension("WEBGL_lose_context").loseContext();
        }
      });
      await page.page.waitForFunction(() => document.querySelectorAll("canvas[role=img]:not([data-lost])").length === 2);
      const isSame = ([value, x, y], i) => value === before[i][0] && Math.hypot(x - before[i][1], y - before[i][2]) < 2;
      await page.until("the pins where they were", said, (now) => now.length === before.length && now.every(isSame));
      assert.deepEqual(page.troubles, []);
    });

    it("of WebGPU that are lost during a run are made again", async () => {
      const other = await open(WEBGPU, COARSE);
      try {
        const { page } = other;
        await page.addInitScript(() => {
          const devices = [];
          const request = GPUAdapter.prototype.requestDevice;
          GPUAdapter.prototype.requestDevice = async function (...given) {
            const device = await request.apply(this, given);
            devices.push(device);
            return device;
          };
          addEventListener("lose devices", () => devices.forEach((device) => device.destroy()));
        });
        const person = new Page(page);
        await page.goto(`${PAGE}?renderer=webgpu`);
        await person.status(/^Running step [1-9]/);
        await page.waitForSelector("html[data-renderer]", { state: "attached" });
        await page.evaluate(() => {
          for (const canvas of document.querySelectorAll("canvas[role=img]")) canvas.dataset.lost = "";
          dispatchEvent(new Event("lose devices"));
        });
        await page.waitForFunction(() => document.querySelectorAll("canvas[role=img]:not([data-lost])").length === 2);
        await person.pressAtOnce("Pause");
        await person.status(/^(Paused|Converged)/);
        await person.drawn();
        assert.ok(variety(decodePng(await person.canvas("Surface view").screenshot())).covered > 0.1, "the surface is drawn again");
      } finally {
        await other.close();
      }
    });
  });

  describe("browsers and meshes", () => {
    after(leave);

    it("without SIMD are told what they lack, in plain HTML", async () => {
      const page = await tab(await visitor({}, () => (WebAssembly.validate = () => false)));
      await page.page.goto(PAGE);
      await page.page.getByText("Cutflow does not run in this browser: it lacks WebAssembly with SIMD.").waitFor();
      assert.match(await page.page.locator("#unsupported").textContent(), /Chrome 91.*Firefox.*Safari 16\.4/);
    });

    it("without workers and WebAssembly are told so, even where modules never run", async () => {
      const context = await visitor({}, () => {
        delete window.Worker;
        delete window.WebAssembly;
      });
      const page = await tab(context);
      await page.page.route(/main\.js/, (route) => route.abort().catch(() => {}));
      await page.page.goto(PAGE);
      await page.page.getByText("it lacks WebAssembly and web workers.").waitFor();
    });

    it("without scripts are told what is needed", async () => {
      const page = await tab(await visitor({ javaScriptEnabled: false }));
      await page.page.goto(PAGE);
      await page.page.getByText(/needs JavaScript and WebAssembly/).waitFor();
    });

    it("without graphics go on cutting, and say so", async () => {
      const page = await tab(
        await visitor({}, () => {
          const get = HTMLCanvasElement.prototype.getContext;
          HTMLCanvasElement.prototype.getContext = function (kind, ...given) {
            return /webgl|webgpu/.test(kind) ? null : get.call(this, kind, ...given);
          };
        }),
      );
      await page.visit(EMPTY);
      const [what] = await page.error();
      assert.match(what, /cannot be drawn/);
      await page.bring("mine.obj", SMALL);
      await page.press("Step");
      await page.status(/^Paused at step 1$/);
    });

    it("too large for the memory are refused before it is taken, and the one before stays", async () => {
      const page = await tab(await visitor());
      await page.visit(EMPTY);
      await page.bring("mine.obj", SMALL);
      await page.page.evaluate(() => {
        const faces = 2_200_000;
        const head = new TextEncoder().encode(
          `ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face ${faces}\nproperty list uchar int vertex_indices\nend_header\n`,
        );
        const bytes = new Uint8Array(head.length + 36 + 13 * faces);
        bytes.set(head);
        const view = new DataView(bytes.buffer);
        [0, 0, 0, 1, 0, 0, 0, 1, 0].forEach((x, i) => view.setFloat32(head.length + 4 * i, x, true));
        for (let f = 0, at = head.length + 36; f < faces; f += 1, at += 13) {
          view.setUint8(at, 3);
          for (let c = 0; c < 3; c += 1) view.setInt32(at + 1 + 4 * c, c, true);
        }
        const transfer = new DataTransfer();
        transfer.items.add(new File([bytes], "huge.ply"));
        for (const type of ["dragenter", "dragover", "drop"]) document.body.dispatchEvent(new DragEvent(type, { dataTransfer: transfer, bubbles: true, cancelable: true }));
      });
      const [what, where, todo] = await page.error();
      assert.match(what, /2200000 triangles.*GiB/);
      assert.equal(where, "huge.ply.");
      assert.match(todo, /Reduce it to \d+ triangles or fewer/);
      assert.match(await page.page.title(), /mine\.obj/);
      await page.press("Dismiss");
      await page.press("Step");
      await page.status(/^Paused at step 1$/);
      assert.deepEqual(page.troubles, []);
    });

    it("that take the place of another can keep its cut", async () => {
      const page = await tab(await visitor());
      await page.visit(EMPTY);
      await page.bring("first.obj", SMALL);
      const [pieces, length] = [await page.measure("Pieces"), await page.measure("Cut length")];
      await page.chooseFile("second.obj", ellipsoid(3));
      await page.page.getByRole("group", { name: "Cut of the mesh before" }).waitFor();
      await screenshot(page.page, "keep-the-cut");
      await page.press("Keep the cut");
      await page.page.waitForFunction(() => document.querySelector("#settings").textContent.includes("Another cut") && [...document.querySelectorAll("#settings select")].some(({ value }) => value === "file"));
      assert.equal(await page.measure("Pieces"), pieces);
      // Borders of labels run in zigzag: a little longer, and never twice as long.
      const ratio = (await page.measure("Cut length")) / length;
      assert.ok(ratio > 0.8 && ratio < 1.5, `the cut is ${ratio} times as long as before`);
      assert.equal(await page.page.getByRole("group", { name: "Cut of the mesh before" }).count(), 0);
      await page.press("Undo");
      assert.deepEqual(page.troubles, []);
    });
  });
});
