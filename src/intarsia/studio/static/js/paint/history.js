/** Undo and redo of painting: what a part looked like before and after, and what it was called. */

/** @typedef {import("./labels.js").Labels} Labels */
/** @typedef {import("./labels.js").Box} Box */
/** @typedef {{labels: Labels | null, back: () => void, again: () => void}} Change null: not of labels */

/** Tells "change" where something was painted, or is as it was before. */
export class History extends EventTarget {
  /** @type {Labels | null} what was changed last */
  last = null;

  /** @param {import("../core/past.js").Past} past where changes are remembered */
  constructor(past) {
    super();
    this.past = past;
  }

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
  add({ labels, back, again }, due) {
    const tell = (/** @type {(() => void)[]} */ ...acts) => {
      for (const act of acts) act();
      this.last = labels;
      this.dispatchEvent(new Event("change"));
    };
    this.past.add(() => tell(back), () => tell(again));
    tell(...(due ? [again] : []));
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
