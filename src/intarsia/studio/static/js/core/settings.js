/** What growing is asked with: options by name, changed one at a time, with undo and redo. Left out means automatic. */

import { kept } from "./kept.js";
import { Past } from "./past.js";
import { titleOf } from "./words.js";

/** @typedef {import("./types.js").Options} Options */

/** @type {Settings[]} */ const all = [];

export class Settings extends EventTarget {
  /** @type {Options} */ #now = {};

  /** @param {string} name under which they are kept @param {Past} [past] where their changes are remembered */
  constructor(name, past = new Past()) {
    super();
    this.name = name;
    this.past = past;
    all.push(this);
  }

  /** @param {Options} options that were kept */
  begin(options) {
    this.#now = options;
    this.dispatchEvent(new Event("change"));
  }

  /** @param {Options} options */
  #go(options) {
    this.#now = options;
    kept.set({ settings: { ...kept.of().settings, [this.name]: options } });
    this.dispatchEvent(new Event("change"));
  }

  /** @returns {Readonly<Options>} */
  get options() {
    return this.#now;
  }

  /** Set one option. Changes of the same one within a moment, as while a number is typed, are undone together.
   * @param {string} name @param {any} value null, undefined or "": automatic */
  set(name, value) {
    const next = { ...this.#now };
    if (value === null || value === undefined || value === "" || value === false) delete next[name];
    else next[name] = value;
    this.#take(next, name);
  }

  /** Take all options anew, as from a recipe.
   * @param {Options} options */
  replace(options) {
    this.#take({ ...options }, "");
  }

  /** @param {Options} next @param {string} name */
  #take(next, name) {
    const before = this.#now;
    if (JSON.stringify(next) === JSON.stringify(before)) return;
    this.#go(next);
    this.past.add(() => this.#go(before), () => this.#go(next), name ? titleOf(name).toLowerCase() : "settings", Boolean(name));
  }
}

/** What the Grow room is set to; it stays while other rooms are visited. */
export const growing = new Settings("grow");

/** Set all as they were left. */
export function restore() {
  for (const each of all) each.begin(kept.of().settings?.[each.name] ?? {});
}
