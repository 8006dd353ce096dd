/** What growing is asked with: options by name, changed one at a time, with undo and redo. Left out means automatic. */

import { kept } from "./kept.js";

/** @typedef {import("./types.js").Options} Options */

const MOMENT = 700;

/** @type {Settings[]} */
const all = [];

export class Settings extends EventTarget {
  /** @type {Options} */
  #now = {};
  /** @type {Options[]} */
  #before = [];
  /** @type {Options[]} */
  #after = [];
  #last = { name: "", at: 0 };

  /** @param {string} name under which they are kept */
  constructor(name) {
    super();
    this.name = name;
    all.push(this);
  }

  /** @param {Options} options that were kept */
  begin(options) {
    this.#now = options;
    this.dispatchEvent(new Event("change"));
  }

  #tell() {
    kept.set({ settings: { ...kept.of().settings, [this.name]: this.#now } });
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
    if (JSON.stringify(next) === JSON.stringify(this.#now)) return;
    const at = Date.now();
    if (!name || name !== this.#last.name || at - this.#last.at > MOMENT || !this.#before.length) {
      this.#before.push(this.#now);
    }
    this.#last = { name, at };
    this.#after = [];
    this.#now = next;
    this.#tell();
  }

  get canUndo() {
    return this.#before.length > 0;
  }

  get canRedo() {
    return this.#after.length > 0;
  }

  undo() {
    this.#step(this.#before, this.#after);
  }

  redo() {
    this.#step(this.#after, this.#before);
  }

  /** @param {Options[]} from @param {Options[]} to */
  #step(from, to) {
    const next = from.pop();
    if (!next) return;
    to.push(this.#now);
    this.#now = next;
    this.#last = { name: "", at: 0 };
    this.#tell();
  }
}

/** What the Grow room is set to; it stays while other rooms are visited. */
export const growing = new Settings("grow");

/** Set all as they were left. */
export function restore() {
  for (const each of all) each.begin(kept.of().settings?.[each.name] ?? {});
}
