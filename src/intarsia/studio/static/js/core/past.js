/** Changes that can be undone, the last one first, and made again. Tells "turned" where one was. */

import { say } from "./toast.js";

/** @typedef {{undo: () => void, redo: () => void, name: string, at: number, open: boolean}} Change `open`: it may go on */

/** Changes of the same thing within so many ms, as while a number is typed, are undone together. */
const MOMENT = 700;
const MOST = 200;

export class Past extends EventTarget {
  /** @type {Change[]} the last one last */
  done = [];
  /** @type {Change[]} what was undone, and can be made again */
  undone = [];

  /** Remember a change that was made.
   * @param {() => void} undo @param {() => void} redo @param {string} [name] of what was changed
   * @param {boolean} [open] whether changes of the same in a moment belong to it */
  add(undo, redo, name = "what was painted", open = false) {
    const at = Date.now();
    const last = this.done.at(-1);
    if (open && last?.open && last.name === name && at - last.at <= MOMENT && !this.undone.length) Object.assign(last, { redo, at });
    else this.done.push({ undo, redo, name, at, open });
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
    change.open = false;
    to.push(change);
    change[way]();
    this.dispatchEvent(new Event("change"));
    say(`${way === "undo" ? "Undone" : "Done again"}: ${change.name}`);
    this.dispatchEvent(new Event("turned"));
  }
}
