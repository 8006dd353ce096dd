/** A picture that is larger than what is loaded of it: its parts are loaded as they come into sight, pixel for pixel. */

import { picture } from "../core/api.js";

const SIDE = 1024;
const MOST = 64; // parts that are kept, of 4 MB each

export class Parts {
  /** @type {Map<string, ImageBitmap | null>} those that were drawn last at the end; null: on the way */
  #held = new Map();

  /** @param {string} path of the picture @param {number} width @param {number} height @param {() => void} arrived */
  constructor(path, width, height, arrived) {
    this.path = path.replace(/\?.*/, "");
    this.width = width;
    this.height = height;
    this.arrived = arrived;
  }

  /** Whether all that were asked for are there. */
  get settled() {
    return this.#held.size > 0 && [...this.#held.values()].every(Boolean);
  }

  /** Draw what is there of all parts in sight, and ask for the others.
   * @param {CanvasRenderingContext2D} pen @param {number} left device px of the picture @param {number} top
   * @param {number} scale */
  draw(pen, left, top, scale) {
    const { width: wide, height: high } = pen.canvas;
    const first = (/** @type {number} */ from) => Math.max(0, Math.floor(-from / scale / SIDE));
    const last = (/** @type {number} */ from, /** @type {number} */ far, /** @type {number} */ all) =>
      Math.min(Math.ceil(all / SIDE), Math.ceil((far - from) / scale / SIDE));
    for (let row = first(top); row < last(top, high, this.height); row += 1) {
      for (let column = first(left); column < last(left, wide, this.width); column += 1) {
        const part = this.#part(column * SIDE, row * SIDE);
        if (!part) continue;
        const [x, y] = [Math.round(left + column * SIDE * scale), Math.round(top + row * SIDE * scale)];
        const right = Math.round(left + (column * SIDE + part.width) * scale);
        const below = Math.round(top + (row * SIDE + part.height) * scale);
        pen.drawImage(part, x, y, right - x, below - y);
      }
    }
  }

  /** @param {number} x @param {number} y @returns {ImageBitmap | null | undefined} */
  #part(x, y) {
    const box = [x, y, Math.min(SIDE, this.width - x), Math.min(SIDE, this.height - y)].join();
    const known = this.#held.get(box);
    if (known === undefined) void this.#load(box);
    else if (known) {
      this.#held.delete(box);
      this.#held.set(box, known);
    }
    return known;
  }

  /** @param {string} box */
  async #load(box) {
    this.#held.set(box, null);
    try {
      this.#held.set(box, await picture(`${this.path}?box=${box}`));
      for (const oldest of this.#held.keys()) {
        if (this.#held.size <= MOST) break;
        this.#held.delete(oldest);
      }
      this.arrived();
    } catch {
      this.#held.delete(box); // asked for again when it is drawn again
    }
  }
}
