/** Changes that can be undone, the last one first, and made again. */

/** @typedef {{undo: () => void, redo: () => void, name: string, at: number}} Change */

/** Changes of the same thing within so many ms, as while a number is typed, are undone together. */
const MOMENT = 700;
const MOST = 200;

export class Past extends EventTarget {
  /** @type {Change[]} the last one last */
  done = [];
  /** @type {Change[]} what was undone, and can be made again */
  undone = [];

  /** Remember a change that was made.
   * @param {() => void} undo @param {() => void} redo @param {string} [name] of what was changed */
  add(undo, redo, name = "") {
    const at = Date.now();
    const last = this.done.at(-1);
    if (name && last?.name === name && at - last.at <= MOMENT && !this.undone.length) Object.assign(last, { redo, at });
    else this.done.push({ undo, redo, name, at });
    if (this.done.length > MOST) this.done.shift();
    this.undone = [];
    this.dispatchEvent(new Event("change"));
  }

  undo() {
    this.#step(this.done, this.undone, "undo");
  }

  redo() {
    this.#step(this.undone, this.done, "redo");
  }

  /** @param {Change[]} from @param {Change[]} to @param {"undo" | "redo"} way */
  #step(from, to, way) {
    const change = from.pop();
    if (!change) return;
    change.name = "";
    to.push(change);
    change[way]();
    this.dispatchEvent(new Event("change"));
  }
}
