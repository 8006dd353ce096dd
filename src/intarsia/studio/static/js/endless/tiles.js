/** The tiles of an endless canvas: those in sight are asked for, nearest first, and given up once they are out of sight. */

import { fresh, Refused } from "../core/api.js";

/** @typedef {{level: number, y: number, x: number}} Place a tile shows 256 * 2 ** level px a side */
/** @typedef {Place & {picture: ImageBitmap, tag: string, weave: string}} Tile `tag`: what its pixels depend on */

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
  /** @type {Map<string, AbortController>} */
  #asked = new Map();
  /** @type {Place[]} */
  #wanted = [];
  /** How many came, and how many were given up: what the page is like at work. */
  came = 0;
  dropped = 0;

  /**
   * Show another canvas. What is there stays until it is known to be otherwise, unless it is another texture.
   * @param {string} weave
   * @param {boolean} anew
   */
  turn(weave, anew) {
    if (weave === this.weave && !anew) return;
    this.weave = weave;
    this.#drop([...this.#asked.keys()]);
    if (anew) {
      for (const tile of this.#held.values()) tile.picture.close();
      this.#held.clear();
    }
    this.#go();
  }

  /** @returns {Iterable<Tile>} all that are there */
  get held() {
    return this.#held.values();
  }

  /** @param {Place} place */
  get(place) {
    return this.#held.get(nameOf(place));
  }

  /** @param {Place} place whether it is there as it is now */
  isFresh(place) {
    return this.get(place)?.weave === this.weave;
  }

  /** How many are asked for and did not come yet. */
  get missing() {
    return this.#wanted.filter((place) => !this.isFresh(place)).length;
  }

  /**
   * Ask for these, the first one first, and for no others.
   * @param {Place[]} places
   */
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
      if (!this.isFresh(place) && !this.#asked.has(nameOf(place))) void this.#ask(place);
    }
  }

  /** @param {Place} place */
  async #ask(place) {
    const name = nameOf(place);
    const control = new AbortController();
    const { weave } = this;
    this.#asked.set(name, control);
    try {
      const path = `/api/weaves/${weave}/${place.y}/${place.x}.png?level=${place.level}`;
      const found = await fresh(path, this.get(place)?.tag ?? "", control.signal);
      if (control.signal.aborted) found.picture?.close();
      else this.#take(place, weave, found);
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

  /**
   * @param {Place} place
   * @param {string} weave
   * @param {{tag: string, picture: ImageBitmap | null}} found no picture: it is the one that is there
   */
  #take(place, weave, { tag, picture }) {
    const name = nameOf(place);
    const before = this.#held.get(name);
    const shown = picture ?? before?.picture;
    if (!shown) return;
    if (picture) before?.picture.close();
    this.#held.delete(name);
    this.#held.set(name, { ...place, picture: shown, tag, weave });
    this.came += 1;
    for (const [oldest, tile] of this.#held) {
      if (this.#held.size <= MOST) break;
      tile.picture.close();
      this.#held.delete(oldest);
    }
    this.dispatchEvent(new Event("change"));
  }
}
