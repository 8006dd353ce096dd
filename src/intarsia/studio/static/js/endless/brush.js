/** The brush of jitter on an endless canvas: strokes are there at once, and their tiles come when they come. */

import { follow } from "../core/dom.js";

/** @typedef {import("./strokes.js").Strokes} Strokes */
/** @typedef {import("./strokes.js").Stroke} Stroke */

const SOFT = 0.75;

export class JitterBrush {
  /** @type {[number, number] | null} where the pointer is */
  #over = null;
  #layer = document.createElement("canvas");

  /**
   * @param {import("./sight.js").Sight} sight
   * @param {Strokes} strokes
   * @param {() => boolean} able whether it can be painted on now
   */
  constructor(sight, strokes, able) {
    this.sight = sight;
    this.strokes = strokes;
    this.able = able;
    sight.tool = this;
    sight.marks = (pen, view) => this.#marks(pen, view);
    const place = (/** @type {PointerEvent} */ e) => {
      const box = sight.getBoundingClientRect();
      this.#over = sight.view.at((e.clientX - box.left) * devicePixelRatio, (e.clientY - box.top) * devicePixelRatio);
      if (strokes.tool !== "move") sight.draw();
    };
    sight.addEventListener("pointermove", place);
    sight.addEventListener("pointerleave", () => [(this.#over = null), sight.draw()]);
    follow(strokes, sight, () => {
      sight.classList.toggle("drawing", strokes.tool !== "move");
      sight.draw();
    });
  }

  /** @type {import("../stage/gestures.js").Stroke["down"]} */
  down(x, y, event) {
    if (this.strokes.tool === "move" || !this.able()) return false;
    this.strokes.begin(x, y, this.strokes.tool === "erase" || (event.buttons & 32) > 0);
    this.sight.draw();
    return true;
  }

  /** @type {import("../stage/gestures.js").Stroke["move"]} */
  move(x, y) {
    this.strokes.go(x, y);
    this.sight.draw();
  }

  /** @type {import("../stage/gestures.js").Stroke["up"]} */
  up(x, y) {
    this.strokes.go(x, y, true);
    this.sight.near = [x, y];
    this.strokes.end();
  }

  /** A second finger came. */
  stop() {
    this.strokes.drawing = null;
    this.sight.draw();
  }

  /** @returns {readonly Stroke[]} those that are shown: all while their tiles are not there */
  get #shown() {
    const { drawing, painted, shown } = this.strokes;
    const all = shown || drawing || (this.strokes.tool !== "move" && this.sight.tiles.missing > 0) ? painted.strokes : [];
    return drawing ? [...all, drawing] : all;
  }

  /**
   * @param {CanvasRenderingContext2D} pen
   * @param {import("../stage/view.js").View} view
   */
  #marks(pen, view) {
    const strokes = this.#shown;
    if (strokes.length) {
      this.#lay(pen.canvas, strokes, view);
      pen.globalAlpha = 0.35;
      pen.drawImage(this.#layer, 0, 0);
      pen.globalAlpha = 1;
    }
    if (!this.#over || this.strokes.tool === "move" || !this.able()) return;
    const [x, y] = this.#over;
    pen.beginPath();
    pen.arc(view.x + x * view.scale, view.y + y * view.scale, Math.max(2, (this.strokes.size / 2) * view.scale), 0, 7);
    for (const [width, colour] of /** @type {[number, string][]} */ ([[3, "rgb(0 0 0 / 60%)"], [1, "#ffffff"]])) {
      pen.lineWidth = width * devicePixelRatio;
      pen.strokeStyle = colour;
      pen.stroke();
    }
  }

  /**
   * Strokes as they lie over each other: the whiter, the more is jittered; what was erased is not there.
   * @param {{width: number, height: number}} size
   * @param {readonly Stroke[]} strokes
   * @param {import("../stage/view.js").View} view
   */
  #lay({ width, height }, strokes, view) {
    const layer = this.#layer;
    if (layer.width !== width || layer.height !== height) [layer.width, layer.height] = [width, height];
    const pen = layer.getContext("2d");
    if (!pen) return;
    pen.clearRect(0, 0, width, height);
    pen.lineCap = pen.lineJoin = "round";
    for (const { points, radius, strength } of strokes) {
      const gray = Math.round(255 * (strength ?? 1));
      pen.globalCompositeOperation = strength === null ? "destination-out" : "source-over";
      pen.strokeStyle = `rgb(${gray} ${gray} ${gray})`;
      pen.lineWidth = Math.max(2, 2 * SOFT * radius * view.scale);
      pen.beginPath();
      const [first] = points;
      if (first) pen.moveTo(view.x + first[0] * view.scale, view.y + first[1] * view.scale);
      for (const [x, y] of points) pen.lineTo(view.x + x * view.scale, view.y + y * view.scale);
      pen.stroke();
    }
    pen.globalCompositeOperation = "source-over";
  }
}
