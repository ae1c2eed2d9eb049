// The two canvases and the viewer behind them: hands over sizes and scenes, and makes new canvases when the graphics are lost. What the
// pointer, the wheel and the keys do is in view-input.js.

import init, { Viewer } from "./pkg/viewer.js";
import { coneHand } from "./cone-hand.js";
import { coneLabels } from "./cone-labels.js";
import { h } from "./dom.js";
import { looking } from "./looking.js";
import { DESCRIPTIONS } from "./panels/describe.js";
import { pieceNumbers } from "./piece-numbers.js";
import { copySquare, enlarged, reduced } from "./pictures.js";
import { listenToView } from "./view-input.js";
import { FLAT, SURFACE } from "./view-names.js";
import { viewTip } from "./view-tip.js";

export { FLAT, SURFACE };

const LABELS = ["Surface view", "Flattened view"];
/** A cut is pointed at from this far beside it, in pixels. */
const SEAM_PX = 7;
/** The ring that shows where a cone would be added. */
const POINT = 0.03;
/** Losing the graphics more often than this in a row means that they cannot be had. */
const REBUILDS = 4;

/** What the address asks for, else WebGPU where browsers have had it for years and it really answers. */
async function chooseRenderer(asked) {
  if (asked === "webgl" || asked === "webgl2") return "webgl2";
  if (asked === "webgpu") return "webgpu";
  const isChromium = navigator.userAgentData?.brands.some(({ brand }) => brand === "Chromium") ?? false;
  return isChromium ? Viewer.probe() : "webgl2";
}

export class Views {
  #hosts;
  #on;
  #viewer = null;
  #renderer = "";
  #scene = null;
  #sceneIsNew = false;
  #flags = { dark: false, texture: "none", cell: 0, isPlain: false, layers: "blended", wireframe: false, hover: -1 };
  #image = null;
  #sizes = ["", ""];
  #rebuilds = 0;
  /** Where the camera of the surface is to be put with the next picture; null where it stays. */
  #pose = null;
  #isBlind = false;
  #pointerAt = null;
  #numbers;
  #tip = viewTip();
  #panTool = false;
  /** What the pointer paints with, and where it is over the surface; null for neither. */
  #brush = null;
  #brushAt = null;
  /** The cones that are pointed at and chosen, -1 for none. */
  #marks = { hover: -1, selected: -1 };
  #hand;
  #labels;
  /** Flights, single pieces, clipping, pins, measuring: see looking.js. */
  look;
  #frame = () => this.#draw();

  /**
   * @param hosts the two elements that hold the canvases
   * @param on `renderer(name)`, `taken()` when a scene was handed to the viewer, `hover(patch)`, `describe(patch)`
   * giving the nodes of the tip, with what else is known of the place as its second argument, `drawn()` after a picture changed, `failed(reason)`; of cones `hoverCone(cone)`,
   * `describeCone(cone)`, `selectCone(cone)`, `moveCone(cone, pick)`, `addCone(pick)`
   */
  constructor(hosts, on) {
    this.#hosts = hosts;
    this.#on = on;
    this.#numbers = pieceNumbers(hosts[FLAT]);
    this.#labels = hosts.map(coneLabels);
    this.#hand = coneHand(() => (this.#scene ? this.#viewer : null), { select: on.selectCone, move: on.moveCone, add: on.addCone });
    this.look = looking(hosts, () => (this.#scene ? this.#viewer : null), on.looking);
    hosts.forEach((host, view) =>
      listenToView(host, view, {
        viewer: () => this.#viewer,
        brush: () => this.#brush,
        hand: this.#hand,
        look: this.look,
        pans: () => this.#panTool,
        aims: () => this.#aims(),
        isConeChosen: () => this.#marks.selected >= 0,
        canvas: () => this.#canvas(view),
        point: (at) => (this.#pointerAt = at),
        aim: (at) => (this.#brushAt = at),
        leave: () => this.#leave(),
        hideTip: this.#tip.hide,
        fit: () => this.fit(view),
        middle: () => this.middle(),
        addCone: on.addCone,
      }),
    );
  }

  async start(asked) {
    try {
      await init();
      this.#renderer = await chooseRenderer(asked);
      await this.#build();
    } catch (error) {
      this.#fail(error);
    }
    requestAnimationFrame(this.#frame);
  }

  // Without pictures scenes are still taken, so that everything else goes on.
  #fail(error) {
    this.#isBlind = true;
    this.#on.failed(String(error?.message ?? error));
  }

  /** Shows a scene with the next frame. */
  setScene(scene) {
    this.#scene = scene;
    this.#sceneIsNew = true;
  }

  setDark(on) {
    this.#flags.dark = on;
    this.#viewer?.set_theme(on);
  }

  /** What the pieces carry, and the side of its cells in the unit of the layout: 0 for one that suits the surface. */
  setTexture(name, cell) {
    this.#flags.texture = name;
    this.#flags.cell = cell;
    this.#viewer?.set_texture(this.#flags.isPlain ? "none" : name, cell);
  }

  /** The pixels that an image of so many is scaled to, `[width, height]`. */
  imageSize(width, height) {
    return [...Viewer.image_size(width, height)];
  }

  /** Takes `{ width, height, bytes }` of the texture `image`. */
  setImage(image) {
    this.#viewer?.set_image(image.width, image.height, image.bytes);
    this.#image = image;
  }

  /** How overlapping charts are drawn: `blended`, `hard` or `pieces`. */
  setLayers(name) {
    this.#flags.layers = name;
    this.#viewer?.set_layers(name);
  }

  /** Whether the texture is left out for now. */
  setPlain(on) {
    this.#flags.isPlain = on;
    this.setTexture(this.#flags.texture, this.#flags.cell);
  }

  /** Side of a texture's cell that suits the surface, in the unit of the layout; 0 while nothing is shown. */
  usualCell() {
    return this.#scene && this.#viewer ? this.#viewer.usual_cell() : 0;
  }

  setWireframe(on) {
    this.#flags.wireframe = on;
    this.#viewer?.set_wireframe(on);
  }

  /** Outlines a patch in both views; -1 for none. */
  setHover(patch) {
    this.look.pointedAt(patch);
    if (this.#flags.hover === patch) return;
    this.#flags.hover = patch;
    this.#viewer?.set_hover(patch);
    this.#on.hover(patch);
  }

  /** Whether there are cones to point at. */
  setCones(on) {
    this.#hand.enable(on);
    if (!on) this.markCones({ hover: -1, selected: -1 });
  }

  /** Whether a click adds a cone. */
  setConeTool(on) {
    this.#hand.setAdds(on);
    this.#brushAt = null;
    this.#hosts.forEach((host) => host.classList.toggle("adding", on));
    this.refreshBrush();
  }

  /** Marks the cones that are pointed at and chosen, each where it is given; -1 for none. */
  markCones(marks) {
    const next = { ...this.#marks, ...marks };
    if (next.hover === this.#marks.hover && next.selected === this.#marks.selected) return;
    const isOther = next.hover !== this.#marks.hover;
    this.#marks = next;
    this.#viewer?.set_cone_marks(next.hover, next.selected);
    if (isOther) this.#on.hoverCone(next.hover);
  }

  /** Gives up the drag of a cone; false if there is none. */
  cancelMove() {
    return this.#hand.cancel();
  }

  /** Draws the cones where the scene has them: what was asked for was refused. */
  dropCone() {
    this.#viewer?.drop_cone();
  }

  /** What lies in the middle of the surface view, undefined where nothing does. */
  middle() {
    const { clientWidth: width, clientHeight: height } = this.#hosts[SURFACE];
    return this.#scene ? this.#viewer?.pick(SURFACE, width / 2, height / 2) : undefined;
  }

  /** Whether a drag over the surface moves it instead of turning it. */
  setPanTool(on) {
    this.#panTool = on;
  }

  /**
   * Takes a brush, null puts it away: `radius()` in the unit of the scene, `stroke(picks, begins, isAlt)` takes the
   * places that a movement has passed. A drag beside the surface, with the right button or with Shift still turns it.
   */
  setBrush(brush) {
    this.#brush = brush;
    this.#brushAt = null;
    this.#leave();
    this.#hosts[SURFACE].classList.toggle("painting", brush !== null);
    this.refreshBrush();
  }

  /** Draws the ring of the brush anew: its size has changed. */
  refreshBrush() {
    const at = this.#brushAt ?? this.#keyboardAt();
    const radius = this.#brush ? this.#brush.radius() : this.#aims() ? POINT : 0;
    this.#viewer?.set_brush(at?.x ?? 0, at?.y ?? 0, at ? radius : 0);
  }

  /** Whether a click sets something at a place, which a ring shows. */
  #aims() {
    return this.#hand.adds() || this.look.measures();
  }

  /** Whether clicks measure. */
  setMeasure(on) {
    this.look.setMeasure(on);
    this.#brushAt = null;
    this.#hosts.forEach((host) => host.classList.toggle("adding", on));
    this.refreshBrush();
  }

  /** Where the keyboard paints: in the middle. */
  #keyboardAt() {
    const canvas = this.#canvas(SURFACE);
    return canvas?.matches(":focus-visible") ? { x: canvas.clientWidth / 2, y: canvas.clientHeight / 2 } : null;
  }

  /** The eye in the frame of the scene, null where nothing is drawn. */
  eye() {
    return this.#viewer && this.#scene ? [...this.#viewer.eye()] : null;
  }

  fit(view) {
    this.#viewer?.fit(view);
  }

  /** Where the camera of the surface stands, to come back to; null where nothing is drawn. */
  pose() {
    return this.#viewer && this.#scene ? [...this.#viewer.pose()] : null;
  }

  /** Puts the camera of the surface there: at once, or with the first picture. */
  setPose(pose) {
    this.#pose = pose;
    if (this.#viewer && this.#scene && !this.#sceneIsNew) this.#takePose();
  }

  #takePose() {
    if (this.#pose) this.#viewer.set_pose(new Float32Array(this.#pose));
    this.#pose = null;
  }

  /** Screen pixels for one unit of the layout, or 0 while nothing is shown. */
  pixelsPerUnit() {
    return this.#scene && this.#viewer ? this.#viewer.chart_pixels_per_unit() : 0;
  }

  /**
   * The picture of a view as a PNG. Drawn and copied in one task: a WebGPU canvas keeps its pixels only so long.
   */
  picture(view, scale = 1) {
    if (!this.#viewer || !this.#scene) return Promise.resolve(null);
    this.#leave();
    this.#viewer.set_brush(0, 0, 0);
    const { copy, context } = enlarged(this.#canvas(view), scale, (width, height, ratio) => {
      this.#viewer.resize(view, width, height, ratio);
      this.#drawAnyway();
    });
    if (view === FLAT) this.#numbers.write(context, this.#viewer.anchors());
    this.#labels[view].write(context);
    this.#sizes[view] = "";
    this.#resize();
    this.#viewer.draw();
    return new Promise((resolve) => copy.toBlob(resolve, "image/png"));
  }

  /** Copies the middle of the surface into a canvas; to be called while `drawn()` is. */
  copySurface(copy) {
    copySquare(this.#canvas(SURFACE), copy);
  }

  /** A small copy of a view as it is now: the middle of the surface, or all of the charts. Null where nothing is drawn. */
  thumbnail(view, width, height) {
    if (!this.#viewer || !this.#scene || this.#sceneIsNew) return null;
    // Drawn and copied in one task, as above.
    this.#drawAnyway();
    return reduced(this.#canvas(view), width, height, view === FLAT);
  }

  /** Setting the theme makes the viewer draw although nothing else may be new. */
  #drawAnyway() {
    this.#viewer.set_theme(this.#flags.dark);
    this.#viewer.shade_whole();
    this.#viewer.draw();
  }

  #canvas(view) {
    return this.#hosts[view].querySelector("canvas");
  }

  // A canvas is married to its first context, so every viewer gets new ones.
  async #build() {
    const old = this.#viewer;
    this.#viewer = null;
    try {
      old?.free();
    } catch {
      // A lost device may refuse to be released; it is gone either way.
    }
    for (const [view, host] of this.#hosts.entries()) {
      const canvas = h("canvas", { role: "img", "aria-label": LABELS[view], "aria-describedby": DESCRIPTIONS[view], tabindex: "0" });
      canvas.addEventListener("webglcontextlost", () => {
        if (this.#canvas(view) === canvas) this.#rebuild();
      });
      this.#canvas(view)?.remove();
      host.prepend(canvas);
    }
    let viewer;
    try {
      viewer = await Viewer.create(this.#canvas(SURFACE), this.#canvas(FLAT), this.#renderer);
    } catch (error) {
      if (this.#renderer !== "webgpu") throw error;
      this.#renderer = "webgl2";
      return this.#build();
    }
    this.#on.renderer(this.#renderer);
    this.#sizes = ["", ""];
    viewer.set_theme(this.#flags.dark);
    viewer.set_texture(this.#flags.isPlain ? "none" : this.#flags.texture, this.#flags.cell);
    viewer.set_layers(this.#flags.layers);
    if (this.#image) viewer.set_image(this.#image.width, this.#image.height, this.#image.bytes);
    viewer.set_wireframe(this.#flags.wireframe);
    viewer.set_cone_marks(this.#marks.hover, this.#marks.selected);
    this.look.restore(viewer);
    this.#viewer = viewer;
    this.#resize();
    if (this.#scene) {
      viewer.set_scene(this.#scene);
      // A new camera has framed nothing yet.
      viewer.fit(SURFACE);
      this.#takePose();
    }
  }

  async #rebuild() {
    if (!this.#viewer) return;
    this.#rebuilds += 1;
    this.#pose = this.pose() ?? this.#pose;
    this.#viewer = null;
    try {
      if (this.#rebuilds > REBUILDS) throw new Error("the graphics were lost again and again");
      if (this.#rebuilds === REBUILDS) this.#renderer = "webgl2";
      await this.#build();
    } catch (error) {
      this.#fail(error);
    }
  }

  #resize() {
    const ratio = devicePixelRatio || 1;
    this.#hosts.forEach((host, view) => {
      const { clientWidth: width, clientHeight: height } = host;
      const size = `${width} ${height} ${ratio}`;
      // A view that is not shown keeps its last size.
      if (width === 0 || height === 0 || this.#sizes[view] === size) return;
      this.#sizes[view] = size;
      this.#leave();
      this.#viewer.resize(view, width, height, ratio);
    });
  }

  #draw() {
    requestAnimationFrame(this.#frame);
    if (this.#isBlind && this.#sceneIsNew) {
      this.#sceneIsNew = false;
      this.#on.taken();
    }
    if (!this.#viewer) return;
    if (this.#viewer.is_lost()) {
      this.#rebuild();
      return;
    }
    this.#resize();
    if (this.#sceneIsNew) {
      this.#sceneIsNew = false;
      try {
        this.#viewer.set_scene(this.#scene);
        this.#takePose();
      } catch (error) {
        // The viewer keeps the picture before; whatever is wrong with this scene, the next may be sound.
        console.error("A scene was refused:", error);
      }
      this.#on.taken();
    }
    this.#pick();
    if (this.#brush || this.#aims()) this.refreshBrush();
    this.look.frame();
    if (!this.#viewer.draw()) return;
    this.#rebuilds = 0;
    if (this.#scene) this.look.drawn();
    this.#numbers.show(this.#scene ? this.#viewer.anchors() : []);
    this.#placeLabels();
    this.#on.drawn();
  }

  #placeLabels() {
    const angles = this.#scene?.cone_angles ?? [];
    const marked = [this.#marks.hover, this.#marks.selected];
    this.#labels.forEach((labels, view) => {
      const numbers = angles.length > 0 ? this.#viewer.cone_labels(view) : [];
      labels.show(numbers, angles, marked);
    });
  }

  // At most one pick a frame, and none while a drag goes on.
  #pick() {
    const at = this.#pointerAt;
    if (!at || !this.#scene) return;
    this.#pointerAt = null;
    if (this.#brush && at.view === SURFACE) return;
    const cone = this.#hand.at(at.view, at);
    this.markCones({ hover: cone });
    this.#hosts[at.view].classList.toggle("on-cone", cone >= 0);
    // With the tool in hand the place matters, not the piece.
    const isCone = cone >= 0 || this.#hand.adds();
    if (isCone) this.#viewer.point_away();
    const pointed = isCone ? {} : this.#viewer.point(at.view, at.x, at.y, SEAM_PX);
    const patch = pointed.patch ?? -1;
    this.look.pointedAt(pointed.seam?.a ?? -1);
    this.setHover(patch);
    const said = cone >= 0 ? this.#on.describeCone(cone) : patch < 0 && !pointed.seam ? [] : this.#on.describe(patch, pointed);
    this.#tip.show(this.#hosts[at.view], at, said);
  }

  #leave() {
    this.#pointerAt = null;
    this.#tip.hide();
    this.#viewer?.point_away();
    this.setHover(-1);
    this.markCones({ hover: -1 });
  }
}
