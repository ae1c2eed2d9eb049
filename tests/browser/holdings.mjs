// What a page holds: its own heap and nodes, the memories of the wasm modules, objects on the graphics card.

/** Counts objects on the graphics card that were made and not yet given back: before the page is visited. */
export function countGraphics(tab) {
  return tab.addInitScript(() => {
    const live = (window.graphics = {});
    for (const kind of ["Buffer", "Texture", "Framebuffer", "Renderbuffer", "VertexArray", "Program", "Shader", "Sampler"]) {
      const [make, free] = [`create${kind}`, `delete${kind}`];
      const { [make]: made, [free]: freed } = WebGL2RenderingContext.prototype;
      live[kind] = 0;
      WebGL2RenderingContext.prototype[make] = function (...rest) {
        live[kind] += 1;
        return made.apply(this, rest);
      };
      WebGL2RenderingContext.prototype[free] = function (object) {
        if (object) live[kind] -= 1;
        return freed.call(this, object);
      };
    }
  });
}

export class Holdings {
  #tab;
  #devtools;

  /** Of a page whose graphics are counted. */
  static async of(tab) {
    const holdings = new Holdings();
    holdings.#tab = tab;
    holdings.#devtools = await tab.context().newCDPSession(tab);
    return holdings;
  }

  /** Bytes of the two wasm memories. Both modules are there already: importing them again gives the same instances. */
  async #wasm() {
    const viewer = await this.#tab.evaluate(async () => (await (await import("./www/pkg/viewer.js")).default()).memory.buffer.byteLength);
    const [worker] = this.#tab.workers();
    const engine = await worker.evaluate(async () => (await (await import(new URL("pkg/engine.js", location.href).href)).default()).memory.buffer.byteLength);
    return { viewer, engine };
  }

  /** Bytes and counts by name, garbage collected. */
  async measure() {
    await this.#devtools.send("HeapProfiler.collectGarbage");
    const { usedSize: heap } = await this.#devtools.send("Runtime.getHeapUsage");
    const { nodes, jsEventListeners: listeners, documents } = await this.#devtools.send("Memory.getDOMCounters");
    const graphics = await this.#tab.evaluate(() => Object.values(window.graphics).reduce((sum, count) => sum + count, 0));
    const canvases = await this.#tab.evaluate(() => document.querySelectorAll("canvas").length);
    return { heap, nodes, listeners, documents, graphics, canvases, workers: this.#tab.workers().length, ...(await this.#wasm()) };
  }
}

/** The names of what has grown by more than a factor. */
export const grown = (before, now, factor) => Object.keys(before).filter((what) => now[what] > factor * before[what]);
