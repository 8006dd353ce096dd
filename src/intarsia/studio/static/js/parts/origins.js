/** Where each pixel of a result came from, for hovering: the map of the result, read when the pointer first comes. */

import { bytes } from "../core/api.js";
import { mapOf, store } from "../core/store.js";

/** @typedef {import("../core/types.js").Result} Result */

/** px: larger maps are not fetched only because a pointer passes. */
const MOST = 1 << 23;

const NOWHERE = 65535;

export class Origins {
  /** @type {Result | null} */
  #result = null;
  /** @type {Uint16Array | null} */
  #map = null;
  #asked = false;

  /** @param {Result | null} result */
  of(result) {
    if (result?.id === this.#result?.id) return;
    this.#result = result;
    this.#map = null;
    this.#asked = false;
    this.#point(null);
  }

  /**
   * The exemplar's pixel that a pixel of the result is.
   * @param {number} x
   * @param {number} y
   * @returns {{exemplar: number, x: number, y: number} | null}
   */
  at(x, y) {
    const result = this.#result;
    if (!result || result.size[0] * result.size[1] > MOST) return null;
    if (!this.#asked) void this.#fetch(result);
    if (!this.#map) return null;
    const first = (y * result.size[0] + x) * 3;
    const [exemplar = NOWHERE, row = 0, column = 0] = this.#map.subarray(first, first + 3);
    return exemplar === NOWHERE ? null : { exemplar, x: column, y: row };
  }

  /**
   * Tell what the pointer is over, and show it on the exemplar.
   * @param {{x: number, y: number} | null} place
   * @returns {string}
   */
  tell(place) {
    const from = place && this.at(place.x, place.y);
    this.#point(from);
    if (!place) return "";
    return `${place.x}, ${place.y}${from ? `  from  ${from.x}, ${from.y}` : ""}`;
  }

  /** @param {{x: number, y: number} | null} place */
  #point(place) {
    if (!place && !store.source) return;
    store.source = place;
    store.tell("source");
  }

  /** @param {Result} result */
  async #fetch(result) {
    this.#asked = true;
    const from = mapOf(result);
    if (!from) return;
    try {
      const map = new Uint16Array(await bytes(`/api/results/${from}/map.bin`));
      if (result.id === this.#result?.id && map.length === result.size[0] * result.size[1] * 3) this.#map = map;
    } catch {
      // its map is gone: then only the place itself is told
    }
  }
}
