/** Where each pixel of a result came from, for hovering: the map of the result, read when the pointer first comes. */

import { originsOf } from "../core/api.js";
import { el } from "../core/dom.js";
import { mapOf, store } from "../core/store.js";

/** @typedef {import("../core/types.js").Result} Result */

/** px a side of the parts that a map is fetched in. */
const SIDE = 512;

const NOWHERE = 65535;

export class Origins {
  /** What the pointer is over, in words. */
  place = el("span", { class: "corner low right number" });
  /** @type {{x: number, y: number} | null} */ #over = null;
  /** @type {Result | null} */ #result = null;
  /** @type {Map<string, Uint16Array | null>} parts of its map; null: on the way, or not to be had */
  #parts = new Map();

  /** @param {Result | null} result */
  of(result) {
    if (result?.id === this.#result?.id) return;
    this.#result = result;
    this.#parts.clear();
    this.#point(null);
  }

  /** The exemplar's pixel that a pixel of the result is.
   * @param {number} x @param {number} y @returns {{exemplar: number, x: number, y: number} | null} */
  at(x, y) {
    const result = this.#result;
    if (!result) return null;
    const [left, top] = [x - (x % SIDE), y - (y % SIDE)];
    const wide = Math.min(SIDE, result.size[0] - left);
    const box = [left, top, wide, Math.min(SIDE, result.size[1] - top)].join();
    const part = this.#parts.get(box);
    if (part === undefined) void this.#fetch(result, box);
    if (!part) return null;
    const first = ((y - top) * wide + x - left) * 3;
    const [exemplar = NOWHERE, row = 0, column = 0] = part.subarray(first, first + 3);
    return exemplar === NOWHERE ? null : { exemplar, x: column, y: row };
  }

  /** Tell what the pointer is over, and show it on the exemplar.
   * @param {{x: number, y: number} | null} place */
  tell(place) {
    this.#over = place;
    const from = place && this.at(place.x, place.y);
    this.#point(from);
    this.place.textContent = place ? `${place.x}, ${place.y}${from ? `  from  ${from.x}, ${from.y}` : ""}` : "";
  }

  /** @param {{x: number, y: number} | null} place */
  #point(place) {
    if (!place && !store.source) return;
    store.source = place;
    store.tell("source");
  }

  /** @param {Result} result @param {string} box */
  async #fetch(result, box) {
    this.#parts.set(box, null);
    const from = mapOf(result);
    if (!from) return;
    try {
      const { size, numbers } = await originsOf(from, box);
      if (result.id === this.#result?.id && size === result.size.join("x")) this.#parts.set(box, numbers);
      this.tell(this.#over);
    } catch {
      // its map is gone: then only the place itself is told
    }
  }
}
