/** The tiles of an endless canvas: those in sight are asked for, nearest first, and given up once they are out of sight. */

import { picture, Refused } from "../core/api.js";

/** @typedef {{level: number, y: number, x: number}} Place a tile shows 256 * 2 ** level px a side */
/** @typedef {Place & {picture: ImageBitmap}} Tile */

export const SIDE = 256;
const AT_ONCE = 3;
const MOST = 400;

/** @param {Place} place */
function nameOf({ level, y, x }) {
  return `${level}/${y}/${x}`;
}

/** Tells "change" where a tile came, "lost" where the server knows the canvas no more, "refused" with its line as detail. */
export class Tiles extends EventTarget {
  /** @type {string} the canvas that is shown; "" before there is one */
  weave = "";
  /** @type {Map<string, Tile>} those used longest ago first */
  #held = new Map();
  /** @type {Map<string, Tile>} those of the canvas before, which are seen until others come in their place */
  former = new Map();
  /** @type {Map<string, AbortController>} */ #asked = new Map();
  /** @type {Place[]} */ #wanted = [];
  /** How many came, and how many were given up: what the page is like at work. */
  came = 0;
  dropped = 0;

  /** @param {string} weave another canvas to show */
  turn(weave) {
    if (weave === this.weave) return;
    this.weave = weave;
    this.#drop([...this.#asked.keys()]);
    if (this.former.size > MOST) this.forget();
    for (const [name, tile] of this.#held) {
      this.former.get(name)?.picture.close();
      this.former.set(name, tile);
    }
    this.#held.clear();
    this.#go();
  }

  /** Keep nothing of the canvases before. */
  forget() {
    for (const tile of this.former.values()) tile.picture.close();
    this.former.clear();
  }

  /** @returns {Iterable<Tile>} all that are there */
  get held() {
    return this.#held.values();
  }

  /** @param {Place} place */
  get(place) {
    return this.#held.get(nameOf(place));
  }

  /** How many are asked for and did not come yet. */
  get missing() {
    return this.#wanted.filter((place) => !this.get(place)).length;
  }

  /** Ask for these, the first one first, and for no others.
   * @param {Place[]} places */
  want(places) {
    this.#wanted = places;
    const names = new Set(places.map(nameOf));
    this.#drop([...this.#asked.keys()].filter((name) => !names.has(name)));
    for (const name of names) {
      const tile = this.#held.get(name);
      if (!tile) continue;
      this.#held.delete(name);
      this.#held.set(name, tile);
    }
    this.#go();
  }

  /** Ask for nothing any more. */
  stop() {
    this.want([]);
  }

  /** @param {string[]} names */
  #drop(names) {
    for (const name of names) {
      this.#asked.get(name)?.abort();
      this.#asked.delete(name);
      this.dropped += 1;
    }
  }

  #go() {
    if (!this.weave) return;
    for (const place of this.#wanted) {
      if (this.#asked.size >= AT_ONCE) return;
      if (!this.get(place) && !this.#asked.has(nameOf(place))) void this.#ask(place);
    }
  }

  /** @param {Place} place */
  async #ask(place) {
    const name = nameOf(place);
    const control = new AbortController();
    this.#asked.set(name, control);
    try {
      const found = await picture(`/api/weaves/${this.weave}/${place.level}/${place.y}/${place.x}.png`, control.signal);
      if (control.signal.aborted) found.close();
      else this.#take(place, found);
    } catch (error) {
      if (control.signal.aborted) return;
      this.#wanted = [];
      const lost = error instanceof Refused && error.status === 404;
      this.dispatchEvent(new CustomEvent(lost ? "lost" : "refused", { detail: error }));
    } finally {
      if (this.#asked.get(name) === control) this.#asked.delete(name);
    }
    this.#go();
  }

  /** @param {Place} place @param {ImageBitmap} picture */
  #take(place, picture) {
    const name = nameOf(place);
    this.#held.set(name, { ...place, picture });
    this.came += 1;
    this.former.get(name)?.picture.close();
    this.former.delete(name);
    if (!this.missing) this.forget();
    for (const [oldest, tile] of this.#held) {
      if (this.#held.size <= MOST) break;
      tile.picture.close();
      this.#held.delete(oldest);
    }
    this.dispatchEvent(new Event("change"));
  }
}
