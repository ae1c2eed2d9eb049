// The two canvases and the viewer behind them. The camera lives in the viewer: this file forwards what the pointer,
// the wheel and the keys do, hands over sizes and scenes, and makes new canvases when the graphics are lost.

import init, { Viewer } from "./pkg/viewer.js";
import { coneHand } from "./cone-hand.js";
import { coneLabels } from "./cone-labels.js";
import { h, s } from "./dom.js";
import { looking } from "./looking.js";
import { DESCRIPTIONS } from "./panels/describe.js";

export const SURFACE = 0;
export const FLAT = 1;

const LABELS = ["Surface view", "Flattened view"];
/** A turn of the wheel by one notch (100 units) zooms by this factor; trackpads send fractions of it. */
const WHEEL_ZOOM = 1.25;
/** Pixels that one press of an arrow key stands for. */
const KEY_DRAG = 24;
/** The longer side of an exported picture has this many pixels at least. */
const PICTURE_PX = 1600;
/** A picture is searched for what is drawn in it at this size. */
const PROBE_PX = 320;
/** The longest side that every graphics backend can draw. */
const MOST_PX = 8192;
/** A press that moves no further is a click. */
const CLICK_PX = 4;
/** A cut is pointed at from this far beside it, in pixels. */
const SEAM_PX = 7;
/** A finger that moves this far paints; one that lifts before has touched, and a second one may still join it. */
const TOUCH_PX = 4;
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

/** The part of a picture in which anything differs from its corner, with a margin: `[x, y, width, height]`; all of it if nothing does. */
function drawnPart(canvas) {
  const small = Math.min(1, PROBE_PX / Math.max(canvas.width, canvas.height));
  const [width, height] = [canvas.width, canvas.height].map((side) => Math.max(1, Math.round(side * small)));
  const context = h("canvas", { width, height }).getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0, width, height);
  const { data } = context.getImageData(0, 0, width, height);
  const differs = (at) => [0, 1, 2].some((i) => Math.abs(data[at + i] - data[i]) > 8);
  let [left, top, right, bottom] = [width, height, -1, -1];
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      if (!differs(4 * (y * width + x))) continue;
      [left, right] = [Math.min(left, x), Math.max(right, x)];
      [top, bottom] = [Math.min(top, y), Math.max(bottom, y)];
    }
  }
  if (right < 0) return [0, 0, canvas.width, canvas.height];
  const margin = 0.04 * Math.max(right - left, bottom - top) + 1;
  const [x, y] = [Math.max(0, left - margin), Math.max(0, top - margin)];
  const [endX, endY] = [Math.min(width, right + 1 + margin), Math.min(height, bottom + 1 + margin)];
  return [x, y, endX - x, endY - y].map((length) => length / small);
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
  #numbers = [];
  #numbersLayer = s("svg", { class: "numbers", "aria-hidden": "true" });
  #tip = h("p", { class: "tip", "aria-hidden": "true", hidden: true });
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
    hosts[FLAT].append(this.#numbersLayer);
    this.#labels = hosts.map(coneLabels);
    this.#hand = coneHand(() => (this.#scene ? this.#viewer : null), { select: on.selectCone, move: on.moveCone, add: on.addCone });
    this.look = looking(hosts, () => (this.#scene ? this.#viewer : null), on.looking);
    hosts.forEach((host, view) => this.#listen(host, view));
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
    const canvas = this.#canvas(view);
    const { clientWidth: width, clientHeight: height } = canvas;
    const longer = Math.max(width, height, 1);
    const ratio = Math.min(scale * Math.max(devicePixelRatio || 1, PICTURE_PX / longer), MOST_PX / longer);
    this.#leave();
    this.#viewer.set_brush(0, 0, 0);
    this.#viewer.resize(view, width, height, ratio);
    // Setting the theme makes the viewer draw although nothing else may be new.
    this.#viewer.set_theme(this.#flags.dark);
    this.#viewer.draw();
    const copy = h("canvas", { width: canvas.width, height: canvas.height });
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0);
    context.scale(canvas.width / width, canvas.height / height);
    if (view === FLAT) this.#writeNumbers(context);
    this.#labels[view].write(context);
    this.#sizes[view] = "";
    this.#resize();
    this.#viewer.draw();
    return new Promise((resolve) => copy.toBlob(resolve, "image/png"));
  }

  /** Copies the middle of the surface, a square, into a canvas; to be called while `drawn()` is. */
  copySurface(copy) {
    const canvas = this.#canvas(SURFACE);
    const side = Math.min(canvas.width, canvas.height);
    const [x, y] = [(canvas.width - side) / 2, (canvas.height - side) / 2];
    copy.getContext("2d").drawImage(canvas, x, y, side, side, 0, 0, copy.width, copy.height);
  }

  /** A small copy of a view as it is now: the middle of the surface, or all of the charts. Null where nothing is drawn. */
  thumbnail(view, width, height) {
    if (!this.#viewer || !this.#scene || this.#sceneIsNew) return null;
    const canvas = this.#canvas(view);
    // Drawn and copied in one task, as above.
    this.#viewer.set_theme(this.#flags.dark);
    this.#viewer.draw();
    const isSurface = view === SURFACE;
    const [x, y, w, d] = isSurface ? [0, 0, canvas.width, canvas.height] : drawnPart(canvas);
    const scale = (isSurface ? Math.max : Math.min)(width / w, height / d);
    const size = [w * scale, d * scale];
    const copy = h("canvas", { width, height });
    const context = copy.getContext("2d");
    context.imageSmoothingQuality = "high";
    context.drawImage(canvas, x, y, w, d, (width - size[0]) / 2, (height - size[1]) / 2, ...size);
    return copy;
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
    this.#placeNumbers();
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

  // The numbers of the pieces are text over the canvas, at a constant size.
  #placeNumbers() {
    const anchors = this.#scene ? this.#viewer.anchors() : [];
    const wanted = anchors.length / 3;
    while (this.#numbers.length < wanted) {
      const text = s("text", {}, String(this.#numbers.length + 1));
      this.#numbers.push(text);
      this.#numbersLayer.append(text);
    }
    while (this.#numbers.length > wanted) this.#numbers.pop().remove();
    this.#numbers.forEach((text, i) => {
      const x = anchors[3 * i];
      const isShown = Number.isFinite(x);
      text.toggleAttribute("hidden", !isShown);
      if (isShown) text.setAttribute("transform", `translate(${x.toFixed(1)} ${anchors[3 * i + 1].toFixed(1)})`);
    });
  }

  #writeNumbers(context) {
    const anchors = this.#viewer.anchors();
    context.font = "600 11px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillStyle = "#1b1d22";
    for (let i = 0; 3 * i < anchors.length; i += 1) {
      if (Number.isFinite(anchors[3 * i])) context.fillText(String(i + 1), anchors[3 * i], anchors[3 * i + 1]);
    }
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
    if (cone >= 0) this.#showTip(at, this.#on.describeCone(cone));
    else this.#showTip(at, patch < 0 && !pointed.seam ? [] : this.#on.describe(patch, pointed));
  }

  #showTip(at, text = []) {
    this.#tip.hidden = text.length === 0;
    if (text.length === 0) return;
    const host = this.#hosts[at.view];
    if (this.#tip.parentElement !== host) host.append(this.#tip);
    this.#tip.replaceChildren(...text);
    // Beside the pointer, on the side where there is room.
    const isLeft = at.x > host.clientWidth / 2;
    const isAbove = at.y > host.clientHeight / 2;
    this.#tip.style.translate = `${isLeft ? "calc(-100% - 14px)" : "14px"} ${isAbove ? "calc(-100% - 10px)" : "14px"}`;
    this.#tip.style.left = `${at.x}px`;
    this.#tip.style.top = `${at.y}px`;
  }

  #leave() {
    this.#pointerAt = null;
    this.#showTip(null);
    this.#viewer?.point_away();
    this.setHover(-1);
    this.markCones({ hover: -1 });
  }

  #listen(host, view) {
    const pointers = new Map();
    const place = (event) => {
      const box = host.getBoundingClientRect();
      return { view, x: event.clientX - box.left, y: event.clientY - box.top };
    };
    const isSide = (event) => event.pointerType === "mouse" && (event.buttons & 6) !== 0;
    const turns = (event) => {
      if (view !== SURFACE) return false;
      // With a brush in hand the other button and Shift stand for the drag that turns.
      if (this.#brush) return !isSide(event) || (event.buttons & 2) !== 0;
      return !this.#panTool && !event.shiftKey && !isSide(event);
    };
    const paints = (event) => view === SURFACE && this.#brush && this.#viewer && !event.shiftKey && !isSide(event);
    /** The pointer that paints, and where a finger has touched that may be about to. */
    let painter = null;
    let touched = null;
    /** The press that may become a click. */
    let pressed = null;
    const paint = (at, event, begins) => {
      const picks = this.#viewer?.stroke(at.x, at.y, this.#brush.radius(), begins) ?? [];
      if (picks.length > 0) this.#brush.stroke(picks, begins, event.altKey);
      return picks.length > 0;
    };

    host.addEventListener("pointerdown", (event) => {
      if (pointers.size === 2) return;
      const isFree = pointers.size === 0 && event.button === 0 && !event.shiftKey && !this.#brush && !this.#hand.adds();
      // A click beside a chosen cone lets go of it and does no more.
      pressed = isFree && this.#marks.selected < 0 ? place(event) : null;
      host.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, place(event));
      this.#canvas(view)?.focus({ preventScroll: true });
      if (view === SURFACE && (this.#brush || this.#aims())) this.#brushAt = place(event);
      if (pointers.size > 1) this.#hand.cancel();
      else if (!(this.#brush && view === SURFACE) && this.#hand.down(view, place(event), event)) {
        this.#showTip(null);
        pressed = null;
        host.classList.add("dragging");
        return;
      }
      if (pointers.size === 1 && paints(event)) {
        if (event.pointerType === "touch") touched = place(event);
        else if (paint(place(event), event, true)) {
          painter = event.pointerId;
          this.#showTip(null);
          return;
        }
      } else [painter, touched] = [null, null];
      host.classList.add("dragging");
      if (event.pointerType !== "mouse") this.#pointerAt = place(event);
      else this.#showTip(null);
    });
    host.addEventListener("pointermove", (event) => {
      const at = place(event);
      const before = pointers.get(event.pointerId);
      if (view === SURFACE && (this.#brush || this.#aims())) this.#brushAt = at;
      if (pressed && Math.hypot(at.x - pressed.x, at.y - pressed.y) > (event.pointerType === "touch" ? 2 : 1) * CLICK_PX) pressed = null;
      if (!before) {
        this.#pointerAt = at;
        return;
      }
      if (touched && this.#brush) {
        if (Math.hypot(at.x - touched.x, at.y - touched.y) < TOUCH_PX) return;
        if (paint(touched, event, true)) painter = event.pointerId;
        touched = null;
      }
      pointers.set(event.pointerId, at);
      if (!this.#viewer || this.#hand.move(at, event)) return;
      if (painter === event.pointerId && this.#brush) {
        for (const part of event.getCoalescedEvents?.() ?? []) paint(place(part), event, false);
        paint(at, event, false);
        return;
      }
      if (pointers.size === 1) {
        if (turns(event)) this.#viewer.rotate(at.x - before.x, at.y - before.y);
        else this.#viewer.pan(view, at.x - before.x, at.y - before.y);
      } else {
        // Two fingers: half of each one's movement, and the change of their distance.
        const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, point]) => point);
        this.#viewer.pan(view, (at.x - before.x) / 2, (at.y - before.y) / 2);
        const distance = (point) => Math.hypot(point.x - other.x, point.y - other.y);
        if (distance(before) > 0) {
          this.#viewer.zoom(view, distance(at) / distance(before), (at.x + other.x) / 2, (at.y + other.y) / 2);
        }
      }
    });
    const release = (event) => {
      if (touched && this.#brush && event.type === "pointerup") paint(touched, event, true);
      [painter, touched] = [null, null];
      if (event.type === "pointerup") this.#hand.up(event);
      else this.#hand.cancel();
      if (event.type === "pointerup" && pressed && pointers.size === 1) this.look.click(pressed);
      pressed = null;
      if (event.pointerType === "touch") this.#brushAt = null;
      pointers.delete(event.pointerId);
      if (pointers.size === 0) host.classList.remove("dragging");
    };
    host.addEventListener("pointerup", release);
    host.addEventListener("pointercancel", release);
    host.addEventListener("pointerleave", (event) => {
      if (pointers.size === 0) this.#brushAt = null;
      if (event.pointerType === "mouse" && pointers.size === 0) this.#leave();
    });
    host.addEventListener("contextmenu", (event) => event.preventDefault());
    host.addEventListener("dblclick", (event) => {
      if (this.#brush || this.#aims() || this.look.doubleClick(place(event))) return;
      this.fit(view);
    });
    host.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        // Lines and pages count as what they usually scroll; a pinch on a trackpad comes as a small wheel with Ctrl.
        const unit = [1, 16, 400][event.deltaMode] * (event.ctrlKey ? 5 : 1);
        const { x, y } = place(event);
        this.#viewer?.zoom(view, WHEEL_ZOOM ** ((-event.deltaY * unit) / 100), x, y);
        this.#showTip(null);
      },
      { passive: false },
    );
    host.addEventListener("keydown", (event) => {
      if (!this.#viewer || event.ctrlKey || event.metaKey || event.altKey) return;
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      const zoom = { "+": WHEEL_ZOOM, "=": WHEEL_ZOOM, "-": 1 / WHEEL_ZOOM }[event.key];
      if (step && view === SURFACE && !event.shiftKey) this.#viewer.rotate(step[0] * KEY_DRAG, step[1] * KEY_DRAG);
      else if (step) this.#viewer.pan(view, step[0] * KEY_DRAG, step[1] * KEY_DRAG);
      else if (zoom) this.#viewer.zoom(view, zoom, host.clientWidth / 2, host.clientHeight / 2);
      else if (event.key === "Enter" && view === SURFACE && this.#brush) {
        paint({ x: host.clientWidth / 2, y: host.clientHeight / 2 }, event, true);
      } else if (event.key === "Enter" && view === SURFACE && this.#hand.adds()) {
        const pick = this.middle();
        if (pick) this.#on.addCone(pick);
      }
      else if (event.key === "Enter" && this.look.measures()) this.look.click({ view, x: host.clientWidth / 2, y: host.clientHeight / 2 });
      else if (event.key === "f" || event.key === "F" || event.key === "Home") this.fit(view);
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
  }
}
