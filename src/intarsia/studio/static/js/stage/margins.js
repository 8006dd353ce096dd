/** A frame around the picture whose sides are dragged outwards: how far it shall be extended. */

/** @typedef {"left" | "right" | "top" | "bottom"} Side */

/** @typedef {Record<Side, number>} Px */

const REACH = matchMedia("(pointer: coarse)").matches ? 24 : 14;
/** How far outside of a picture that is not extended yet its frame is drawn, as a share of the shorter side. */
const AWAY = 0.125;

export class Margins {
  /** @type {Px} px of the picture */
  px = { left: 0, right: 0, top: 0, bottom: 0 };
  /** @type {string} what they belong to */
  own = "";
  /** @type {Side[]} sides that are held */
  held = [];
  #before = this.px;

  /** @param {import("./stage.js").Stage} stage @param {import("../core/past.js").Past} past @param {() => void} changed */
  constructor(stage, past, changed) {
    this.stage = stage;
    this.past = past;
    this.changed = changed;
  }

  /** Whether nothing is to be added yet. */
  get none() {
    return Object.values(this.px).every((px) => !px);
  }

  /** How much room the frame needs around the picture, in its px. */
  get around() {
    const { width, height } = this.stage.size;
    return Math.max(2 * AWAY * Math.min(width, height), ...Object.values(this.px));
  }

  /** The frame's borders in picture pixels.
   * @param {boolean} [away] outside of the picture where nothing is added yet */
  frame(away = false) {
    const { width, height } = this.stage.size;
    const out = away && this.none ? AWAY * Math.min(width, height) : 0;
    const { left, right, top, bottom } = this.px;
    return { left: -left - out, right: width + right + out, top: -top - out, bottom: height + bottom + out };
  }

  /** @param {Px} px */
  #put(px) {
    this.px = px;
    this.changed();
  }

  /** Take others, and remember what was before.
   * @param {Px} px @param {string} [name] of what is typed @param {Px} [before] */
  set(px, name, before = this.px) {
    const { own } = this;
    const put = (/** @type {Px} */ one) => this.own === own && this.#put(one);
    put(px);
    this.past.add(() => put(before), () => put(px), name ?? "frame", Boolean(name));
  }

  /** The sides that are near to a place: one, or two at a corner.
   * @param {number} x @param {number} y @param {boolean} away whether it is the frame that is drawn @returns {Side[]} */
  near(x, y, away) {
    const reach = (REACH * devicePixelRatio) / this.stage.view.scale;
    const { left, right, top, bottom } = this.frame(away);
    const beside = x > left - reach && x < right + reach && y > top - reach && y < bottom + reach;
    /** @type {Side[]} */ const sides = [];
    if (!beside) return sides;
    if (Math.abs(x - left) < reach) sides.push("left");
    else if (Math.abs(x - right) < reach) sides.push("right");
    if (Math.abs(y - top) < reach) sides.push("top");
    else if (Math.abs(y - bottom) < reach) sides.push("bottom");
    return sides;
  }

  /** @type {import("./gestures.js").Stroke["down"]} */
  down(x, y) {
    this.held = this.near(x, y, true);
    if (!this.held.length) this.held = this.near(x, y, false);
    this.#before = this.px;
    return this.held.length > 0;
  }

  /** @type {import("./gestures.js").Stroke["move"]} */
  move(x, y) {
    const { width, height } = this.stage.size;
    const far = { left: -x, right: x - width, top: -y, bottom: y - height };
    const held = this.held.map((side) => [side, Math.max(0, Math.min(8192, Math.round(far[side])))]);
    this.#put({ ...this.px, ...Object.fromEntries(held) });
  }

  up() {
    this.held = [];
    if (this.px !== this.#before) this.set(this.px, "", this.#before);
  }

  stop() {
    this.held = [];
    this.#put(this.#before);
  }

  /** @type {NonNullable<import("./stage.js").Stage["marks"]>} */
  marks(pen, view) {
    const { left, right, top, bottom } = this.frame(true);
    const [x, y] = [Math.round(view.x + left * view.scale), Math.round(view.y + top * view.scale)];
    const [wide, high] = [Math.round((right - left) * view.scale), Math.round((bottom - top) * view.scale)];
    pen.lineWidth = devicePixelRatio;
    pen.setLineDash(this.none ? [8 * devicePixelRatio, 6 * devicePixelRatio] : []);
    pen.strokeStyle = "rgb(0 0 0 / 70%)";
    pen.strokeRect(x - 1.5, y - 1.5, wide + 3, high + 3);
    pen.strokeStyle = "#ffffff";
    pen.strokeRect(x - 0.5, y - 0.5, wide + 1, high + 1);
    pen.setLineDash([]);
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
