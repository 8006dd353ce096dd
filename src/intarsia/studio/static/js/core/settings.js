/** What growing is asked with: options by name, changed one at a time, with undo and redo. Left out means automatic. */

/** @typedef {import("./types.js").Options} Options */

const MOMENT = 700;

export class Settings extends EventTarget {
  /** @type {Options} */
  #now;
  /** @type {Options[]} */
  #before = [];
  /** @type {Options[]} */
  #after = [];
  #last = { name: "", at: 0 };

  /** @param {Options} [begin] */
  constructor(begin = {}) {
    super();
    this.#now = begin;
  }

  /** @returns {Readonly<Options>} */
  get options() {
    return this.#now;
  }

  /**
   * Set one option. Changes of the same one within a moment, as while a number is typed, are undone together.
   * @param {string} name
   * @param {any} value null, undefined or "": automatic
   */
  set(name, value) {
    const next = { ...this.#now };
    if (value === null || value === undefined || value === "" || value === false) delete next[name];
    else next[name] = value;
    this.#take(next, name);
  }

  /**
   * Take all options anew, as from a recipe.
   * @param {Options} options
   */
  replace(options) {
    this.#take({ ...options }, "");
  }

  /**
   * @param {Options} next
   * @param {string} name
   */
  #take(next, name) {
    if (JSON.stringify(next) === JSON.stringify(this.#now)) return;
    const at = Date.now();
    if (!name || name !== this.#last.name || at - this.#last.at > MOMENT || !this.#before.length) {
      this.#before.push(this.#now);
    }
    this.#last = { name, at };
    this.#after = [];
    this.#now = next;
    this.dispatchEvent(new Event("change"));
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

  /**
   * @param {Options[]} from
   * @param {Options[]} to
   */
  #step(from, to) {
    const next = from.pop();
    if (!next) return;
    to.push(this.#now);
    this.#now = next;
    this.#last = { name: "", at: 0 };
    this.dispatchEvent(new Event("change"));
  }
}

/** What the Grow room is set to; it stays while other rooms are visited. */
export const growing = new Settings();
