/** Undo and redo of painting: what a part looked like before and after, and what it was called. */

/** @typedef {import("./labels.js").Labels} Labels */
/** @typedef {import("./labels.js").Box} Box */
/** @typedef {{labels: Labels | null, back: () => void, again: () => void}} Change null: not of labels, but of their names */

const MOST = 200;

export class History extends EventTarget {
  /** @type {Change[]} */
  #done = [];
  /** @type {Change[]} */
  #undone = [];
  /** @type {Labels | null} what was changed last */
  last = null;

  /** Remember a change that was made to a copy's original.
   * @param {Labels} labels as they are now @param {Uint8Array} before all of them as they were */
  note(labels, before) {
    const box = difference(labels, before);
    if (!box) return;
    const [was, is] = [cut(before, labels.width, box), cut(labels.data, labels.width, box)];
    this.add({ labels, back: () => put(labels, box, was), again: () => put(labels, box, is) });
  }

  /** Remember what was done.
   * @param {Change} change @param {boolean} [due] whether it is to be done now */
  add(change, due) {
    if (this.#done.length === MOST) this.#done.shift();
    this.#undone = [];
    this.#step([change], this.#done, due ? "again" : null);
  }

  get canUndo() {
    return this.#done.length > 0;
  }

  get canRedo() {
    return this.#undone.length > 0;
  }

  undo() {
    this.#step(this.#done, this.#undone, "back");
  }

  redo() {
    this.#step(this.#undone, this.#done, "again");
  }

  /** @param {Change[]} from @param {Change[]} to @param {"back" | "again" | null} way */
  #step(from, to, way) {
    const change = from.pop();
    if (!change) return;
    to.push(change);
    if (way) change[way]();
    this.last = change.labels;
    this.dispatchEvent(new Event("change"));
  }
}

/** @param {Labels} labels @param {Box} box @param {Uint8Array} part */
function put(labels, box, part) {
  for (let row = 0; row < box.height; row += 1) {
    labels.data.set(part.subarray(row * box.width, (row + 1) * box.width), (box.y + row) * labels.width + box.x);
  }
  labels.paint(box);
}

/** The part in which two differ.
 * @param {Labels} labels @param {Uint8Array} before @returns {Box | null} */
function difference({ width, height, data }, before) {
  let [left, right, top, below] = [width, -1, height, -1];
  for (let row = 0; row < height; row += 1) {
    for (let column = 0, at = row * width; column < width; column += 1, at += 1) {
      if (data[at] === before[at]) continue;
      if (column < left) left = column;
      if (column > right) right = column;
      if (row < top) top = row;
      below = row;
    }
  }
  return right < 0 ? null : { x: left, y: top, width: right - left + 1, height: below - top + 1 };
}

/** @param {Uint8Array} data @param {number} wide @param {Box} box */
function cut(data, wide, { x, y, width, height }) {
  const part = new Uint8Array(width * height);
  for (let row = 0; row < height; row += 1) {
    part.set(data.subarray((y + row) * wide + x, (y + row) * wide + x + width), row * width);
  }
  return part;
}
