/** The tools that paint numbers on a stage: brush, eraser and fill; they take the strokes of a pointer and never wait. */

import { follow } from "../core/dom.js";
import { Past } from "../core/past.js";
import { History } from "./history.js";

/** @typedef {"brush" | "erase" | "fill" | "move"} Tool */

/** What is painted with, wherever it is painted. */
export class Kit extends EventTarget {
  /** @type {Tool} */ tool = "brush";
  size = 32;
  value = 1;
  past = new Past();
  history = new History(this.past);

  constructor() {
    super();
    this.history.addEventListener("change", () => this.tell());
  }

  /** @param {Partial<{tool: Tool, size: number, value: number}>} change */
  set(change) {
    Object.assign(this, change);
    this.size = Math.max(1, Math.min(512, Math.round(this.size)));
    this.tell();
  }

  tell() {
    this.dispatchEvent(new Event("change"));
  }
}

/** Paints on one stage. */
export class Brush {
  /** @type {[number, number] | null} */ #last = null;
  /** @type {Uint8Array | null} */ #before = null;
  /** @type {[number, number] | null} where the pointer is */
  #over = null;

  /** @param {import("../stage/stage.js").Stage} stage @param {Kit} kit @param {() => import("./labels.js").Labels | null} labels that are painted on now */
  constructor(stage, kit, labels) {
    this.stage = stage;
    this.kit = kit;
    this.labels = labels;
    stage.tool = this;
    stage.marks = (pen, view) => this.ring(pen, view);
    const place = (/** @type {PointerEvent} */ e) => {
      const box = stage.getBoundingClientRect();
      this.#over = stage.view.at((e.clientX - box.left) * devicePixelRatio, (e.clientY - box.top) * devicePixelRatio);
      stage.draw();
    };
    stage.addEventListener("pointermove", place);
    stage.addEventListener("pointerleave", () => [(this.#over = null), stage.draw()]);
    follow(kit, stage, () => {
      stage.classList.toggle("drawing", kit.tool !== "move");
      stage.draw();
    });
  }

  /** The middle of the brush: that of a pixel, or a corner, as its size is odd or even.
   * @param {number} x @param {number} y @returns {[number, number]} */
  #middle(x, y) {
    return this.kit.size % 2 ? [Math.floor(x) + 0.5, Math.floor(y) + 0.5] : [Math.round(x), Math.round(y)];
  }

  /** @param {PointerEvent} event whether the pen is turned round */
  #value(event) {
    return this.kit.tool === "erase" || event.buttons & 32 ? 0 : this.kit.value;
  }

  /** @type {import("../stage/gestures.js").Stroke["down"]} */
  down(x, y, event) {
    const labels = this.labels();
    if (!labels || this.kit.tool === "move") return false;
    this.#before = labels.data.slice();
    if (this.kit.tool === "fill") {
      const [column, row] = [Math.floor(x), Math.floor(y)];
      if (column < 0 || row < 0 || column >= labels.width || row >= labels.height) return false;
      labels.paint(labels.flood(column, row, this.kit.value));
      this.stage.draw();
      return true;
    }
    this.#last = this.#middle(x, y);
    this.#go(labels, this.#last, this.#value(event));
    return true;
  }

  /** @type {import("../stage/gestures.js").Stroke["move"]} */
  move(x, y, event) {
    const labels = this.labels();
    if (labels && this.#last) this.#go(labels, this.#middle(x, y), this.#value(event));
  }

  up() {
    const labels = this.labels();
    if (labels && this.#before) this.kit.history.note(labels, this.#before);
    this.#last = this.#before = null;
  }

  /** A second finger came: what the first did is taken back. */
  stop() {
    const labels = this.labels();
    if (labels && this.#before) {
      labels.data.set(this.#before);
      labels.paint();
      this.stage.draw();
    }
    this.#last = this.#before = null;
  }

  /** @param {import("./labels.js").Labels} labels @param {[number, number]} to @param {number} value */
  #go(labels, to, value) {
    labels.paint(labels.stroke(this.#last ?? to, to, this.kit.size / 2, value));
    this.#last = to;
    this.stage.draw();
  }

  /** Draw how large the brush is.
   * @param {CanvasRenderingContext2D} pen @param {import("../stage/view.js").View} view */
  ring(pen, view) {
    if (!this.#over || !["brush", "erase"].includes(this.kit.tool)) return;
    const [x, y] = this.#middle(...this.#over);
    pen.beginPath();
    pen.arc(view.x + x * view.scale, view.y + y * view.scale, Math.max(2, (this.kit.size / 2) * view.scale), 0, 7);
    pen.lineWidth = 3 * devicePixelRatio;
    pen.strokeStyle = "rgb(0 0 0 / 60%)";
    pen.stroke();
    pen.lineWidth = devicePixelRatio;
    pen.strokeStyle = "#ffffff";
    pen.stroke();
  }
}
