/** A frame around the picture whose sides are dragged outwards: how far it shall be extended. */

/** @typedef {"left" | "right" | "top" | "bottom"} Side */

const REACH = 14;

export class Margins {
  /** @type {Record<Side, number>} px of the picture */
  px = { left: 0, right: 0, top: 0, bottom: 0 };
  /** @type {Side[]} sides that are held */
  #held = [];

  /** @param {import("./stage.js").Stage} stage @param {() => void} changed */
  constructor(stage, changed) {
    this.stage = stage;
    this.changed = changed;
  }

  /** The frame's borders in picture pixels. */
  get frame() {
    const { width, height } = this.stage.size;
    const { left, right, top, bottom } = this.px;
    return { left: -left, right: width + right, top: -top, bottom: height + bottom };
  }

  /** The sides that are near to a place: one, or two at a corner.
   * @param {number} x @param {number} y @returns {Side[]} */
  near(x, y) {
    const reach = (REACH * devicePixelRatio) / this.stage.view.scale;
    const { left, right, top, bottom } = this.frame;
    const beside = x > left - reach && x < right + reach && y > top - reach && y < bottom + reach;
    /** @type {Side[]} */
    const sides = [];
    if (!beside) return sides;
    if (Math.abs(x - left) < reach) sides.push("left");
    else if (Math.abs(x - right) < reach) sides.push("right");
    if (Math.abs(y - top) < reach) sides.push("top");
    else if (Math.abs(y - bottom) < reach) sides.push("bottom");
    return sides;
  }

  /** @type {import("./gestures.js").Stroke["down"]} */
  down(x, y) {
    this.#held = this.near(x, y);
    return this.#held.length > 0;
  }

  /** @type {import("./gestures.js").Stroke["move"]} */
  move(x, y) {
    const { width, height } = this.stage.size;
    const far = { left: -x, right: x - width, top: -y, bottom: y - height };
    for (const side of this.#held) this.px[side] = Math.max(0, Math.min(8192, Math.round(far[side])));
    this.stage.draw();
    this.changed();
  }

  up() {
    this.#held = [];
  }

  stop() {
    this.#held = [];
  }

  /** @type {NonNullable<import("./stage.js").Stage["marks"]>} */
  marks(pen, view) {
    const { left, right, top, bottom } = this.frame;
    const [x, y] = [Math.round(view.x + left * view.scale), Math.round(view.y + top * view.scale)];
    const [wide, high] = [Math.round((right - left) * view.scale), Math.round((bottom - top) * view.scale)];
    pen.lineWidth = devicePixelRatio;
    pen.strokeStyle = "rgb(0 0 0 / 70%)";
    pen.strokeRect(x - 1.5, y - 1.5, wide + 3, high + 3);
    pen.strokeStyle = "#ffffff";
    pen.strokeRect(x - 0.5, y - 0.5, wide + 1, high + 1);
    const half = 5 * devicePixelRatio;
    for (const [u, v] of [[0, 0.5], [1, 0.5], [0.5, 0], [0.5, 1], [0, 0], [1, 0], [0, 1], [1, 1]]) {
      const [a, b] = [x + wide * (u ?? 0), y + high * (v ?? 0)];
      pen.fillStyle = "rgb(0 0 0 / 70%)";
      pen.fillRect(a - half - 1, b - half - 1, 2 * half + 2, 2 * half + 2);
      pen.fillStyle = "#ffffff";
      pen.fillRect(a - half, b - half, 2 * half, 2 * half);
    }
  }
}
