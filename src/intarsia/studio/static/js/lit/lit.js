/** A material under a lamp that is dragged over it, or moved by arrow keys; with sliders for its height and brightness. */

import { el } from "../core/dom.js";
import { store } from "../core/store.js";
import { readable } from "../core/words.js";
import { segments } from "../parts/choice.js";
import { MAPS, Renderer } from "./renderer.js";
import { SHAPES } from "./shaders.js";

/**
 * What may be lit.
 * @typedef {object} Subject
 * @property {string} id
 * @property {string[]} planes
 * @property {(plane: string) => string} at where what can be seen of a plane lies
 * @property {boolean} down whether green of its normals points down the picture
 */

/** The lamp stays where it was put while other results are looked at. */
const lamp = { x: 0.3, y: 0.26, height: 0.42, power: 1.5 };

/** @type {import("./renderer.js").Pose} */ const pose = { shape: "flat", turn: 30, tilt: 22, relief: 0.06 };

const STEP = 0.02;

/** Whether there is anything to light: slopes of the surface.
 * @param {string[]} planes */
export function canBeLit(planes) {
  return planes.includes("normal") || planes.includes("height");
}

export class Lit {
  handle = el("div", {
    class: "lamp", role: "slider", tabIndex: 0, "aria-label": "Lamp", "aria-valuemin": "0", "aria-valuemax": "100", hidden: true,
    title: "Drag the lamp, or move it with the arrow keys",
  });
  panel = el(
    "div",
    { class: "lamp-panel", role: "group", "aria-label": "Lamp", hidden: true },
    segments("Shape", SHAPES.map((shape) => [shape, readable(shape)]), () => pose.shape, (shape) => this.#pose({ shape })).element,
    slider("Distance", 8, 150, () => 100 * lamp.height, (value) => this.#set({ height: value / 100 })),
    slider("Brightness", 10, 400, () => 100 * lamp.power, (value) => this.#set({ power: value / 100 })),
  );
  turn = slider("Turn", 0, 360, () => pose.turn, (turn) => this.#pose({ turn }));
  relief = slider("Depth", 0, 25, () => 100 * pose.relief, (value) => this.#pose({ relief: value / 100 }));
  /** @type {Renderer | null} */ #renderer = null;
  /** @type {Subject | null} that is lit */
  #subject = null;
  /** @type {string} what the renderer holds */
  #held = "";

  /** @param {import("../stage/stage.js").Stage} stage */
  constructor(stage) {
    this.stage = stage;
    this.panel.append(this.turn, this.relief);
    stage.append(this.handle, this.panel);
    for (const kind of ["pointerdown", "pointermove", "keydown", "wheel", "dblclick"]) {
      this.panel.addEventListener(kind, (e) => e.stopPropagation());
    }
    this.handle.addEventListener("dblclick", (e) => e.stopPropagation());
    this.handle.addEventListener("pointerdown", (e) => {
      e.stopPropagation();
      this.handle.setPointerCapture(e.pointerId);
      this.handle.focus({ preventScroll: true });
    });
    this.handle.addEventListener("pointermove", (e) => this.#drag(e));
    this.handle.addEventListener("keydown", (e) => this.#key(e));
  }

  /** Light a material; whether that can be done here.
   * @param {Subject} subject @param {() => boolean} still whether it is still wanted when all its maps are there
   * @returns {Promise<boolean>} */
  async show(subject, still) {
    const renderer = this.#renderer ?? Renderer.begin();
    if (!renderer) return false;
    if (!this.#renderer) renderer.canvas.addEventListener("webglcontextlost", () => void this.#again(subject), { once: true });
    this.#renderer = renderer;
    const wanted = MAPS.map((map) => map.name).filter((name) => subject.planes.includes(name));
    const base = subject.planes[0];
    if (base && !wanted.includes("albedo") && base !== "normal" && base !== "height") wanted.unshift("albedo");
    /** @type {import("./renderer.js").Maps} */ const maps = {};
    await Promise.all(
      wanted.map(async (name) => {
        maps[name] = await store.picture(subject.at(subject.planes.includes(name) ? name : (base ?? name)));
      }),
    );
    if (!still()) return true;
    this.#subject = subject;
    if (this.#held !== subject.id) renderer.take(maps, subject.down);
    this.#held = subject.id;
    this.stage.painter = (canvas, view, size, tiles) => renderer.draw(canvas, this.#above(view, canvas.width / 2), size, tiles, lamp, pose);
    this.relief.hidden = !subject.planes.includes("height");
    this.handle.hidden = this.panel.hidden = false;
    this.#place();
    this.#pose({});
    return true;
  }

  /** The graphics card was taken away: begin anew, or else show the picture as it is.
   * @param {Subject} subject */
  async #again(subject) {
    this.#renderer = null;
    this.#held = "";
    const shown = this.stage.painter;
    if (!shown) return;
    const there = await this.show(this.#subject ?? subject, () => this.stage.painter === shown);
    if (!there) this.hide();
  }

  /** A solid is drawn smaller, above what is set of it.
   * @param {{x: number, y: number, scale: number}} view @param {number} middle of the stage */
  #above({ x, y, scale }, middle) {
    const part = pose.shape === "flat" ? 1 : 1 - (this.panel.offsetHeight + 24) / Math.max(100, this.stage.clientHeight);
    return { x: middle + (x - middle) * part, y: y * part, scale: scale * part };
  }

  /** Show the picture as it is. */
  hide() {
    this.handle.hidden = this.panel.hidden = true;
    this.stage.painter = null;
    if (this.stage.tool === this.turning) this.stage.tool = null;
    this.stage.draw();
  }

  /** Turn the solid by dragging; a picture that is flat is moved.
   * @type {import("../stage/gestures.js").Stroke} */
  turning = {
    down: () => true,
    move: (x, y, event) => this.#pose({ turn: pose.turn - event.movementX / 2, tilt: pose.tilt + event.movementY / 2 }),
    up: () => {},
    stop: () => {},
  };

  /** @param {Partial<typeof pose>} change */
  #pose(change) {
    Object.assign(pose, change);
    pose.turn = (pose.turn + 360) % 360;
    pose.tilt = Math.max(-80, Math.min(80, pose.tilt));
    const solid = pose.shape !== "flat";
    this.stage.tool = solid ? this.turning : null;
    this.turn.hidden = !solid;
    const range = this.turn.querySelector("input");
    if (range) range.value = String(Math.round(pose.turn));
    this.stage.draw();
  }

  /** @param {PointerEvent} event */
  #drag(event) {
    if (!this.handle.hasPointerCapture(event.pointerId)) return;
    event.stopPropagation();
    const box = this.stage.getBoundingClientRect();
    this.#set({ x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height });
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const far = event.shiftKey ? 5 * STEP : STEP;
    /** @type {Record<string, [number, number]>} */
    const ways = { ArrowLeft: [-far, 0], ArrowRight: [far, 0], ArrowUp: [0, -far], ArrowDown: [0, far] };
    const way = ways[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    this.#set({ x: lamp.x + way[0], y: lamp.y + way[1] });
  }

  /** @param {Partial<typeof lamp>} change */
  #set(change) {
    Object.assign(lamp, change);
    lamp.x = Math.max(0, Math.min(1, lamp.x));
    lamp.y = Math.max(0, Math.min(1, lamp.y));
    this.#place();
  }

  #place() {
    const [across, down] = [Math.round(100 * lamp.x), Math.round(100 * lamp.y)];
    this.handle.style.left = `${100 * lamp.x}%`;
    this.handle.style.top = `${100 * lamp.y}%`;
    this.handle.setAttribute("aria-valuenow", String(across));
    this.handle.setAttribute("aria-valuetext", `${across} % from the left, ${down} % from the top`);
    this.stage.draw();
  }
}

/** @param {string} name @param {number} low @param {number} high @param {() => number} now
 * @param {(value: number) => void} set */
function slider(name, low, high, now, set) {
  const range = el("input", {
    class: "range", type: "range", min: String(low), max: String(high), step: "1", value: String(Math.round(now())),
    oninput: () => set(Number(range.value)),
  });
  return el("label", {}, name, range);
}
