/** Numbers painted over a picture: one whole number a pixel, never a mixture of two. A canvas shows them; it decides nothing. */

/** Colours of labels, far enough from each other for most eyes; red, green, blue. */
export const COLOURS = [
  [122, 122, 122], [230, 110, 60], [70, 150, 220], [240, 205, 70], [90, 180, 110], [190, 110, 200], [60, 190, 190],
  [200, 70, 100],
].map((colour) => /** @type {[number, number, number]} */ (colour));

/** @typedef {{x: number, y: number, width: number, height: number}} Box */
/** @typedef {{side: number, pixels: Uint32Array}} Ink what a label is drawn with: a square that is repeated from (0, 0) on */

/** @type {Ink[]} of labels that look like nothing yet */
export const FLAT = COLOURS.map(([r, g, b]) => ({ side: 1, pixels: Uint32Array.of(((255 << 24) | (b << 16) | (g << 8) | r) >>> 0) }));

const NONE = { side: 1, pixels: new Uint32Array(1) };

export class Labels {
  /** @param {number} width @param {number} height @param {boolean} [ground] whether the number 0 is seen, too */
  constructor(width, height, ground = false) {
    this.width = width;
    this.height = height;
    this.inks = [ground ? FLAT[0] ?? NONE : NONE, ...FLAT.slice(1)];
    this.data = new Uint8Array(width * height);
    this.canvas = new OffscreenCanvas(width, height);
    this.version = 0; // one more whenever something was painted
    this.known = new Uint8Array(); // where the numbers are still these nothing is drawn, so that what lies below is seen
    this.paint();
  }

  /** Give a number to all pixels whose middle lies within `radius` of a line: a stroke of a round, hard brush.
   * @param {[number, number]} from @param {[number, number]} to @param {number} radius @param {number} value
   * @returns {Box} what may have changed */
  stroke([ax, ay], [bx, by], radius, value) {
    const left = Math.max(0, Math.floor(Math.min(ax, bx) - radius));
    const top = Math.max(0, Math.floor(Math.min(ay, by) - radius));
    const right = Math.min(this.width, Math.ceil(Math.max(ax, bx) + radius));
    const below = Math.min(this.height, Math.ceil(Math.max(ay, by) + radius));
    const [dx, dy] = [bx - ax, by - ay];
    const long = dx * dx + dy * dy;
    const most = radius * radius + 1e-6;
    for (let row = top; row < below; row += 1) {
      const v = row + 0.5 - ay;
      for (let column = left; column < right; column += 1) {
        const u = column + 0.5 - ax;
        const share = long > 0 ? Math.max(0, Math.min(1, (u * dx + v * dy) / long)) : 0;
        const [p, q] = [u - share * dx, v - share * dy];
        if (p * p + q * q <= most) this.data[row * this.width + column] = value;
      }
    }
    return { x: left, y: top, width: Math.max(0, right - left), height: Math.max(0, below - top) };
  }

  /** Give a number to all pixels that hang together with this one and have the same number.
   * @param {number} x @param {number} y @param {number} value @returns {Box} */
  flood(x, y, value) {
    const { width, height, data } = this;
    const old = data[y * width + x];
    if (old === undefined || old === value) return { x, y, width: 0, height: 0 };
    const open = [y * width + x];
    while (open.length) {
      const at = /** @type {number} */ (open.pop());
      if (data[at] !== old) continue;
      const row = at - (at % width);
      let [left, right] = [at, at];
      while (left > row && data[left - 1] === old) left -= 1;
      while (right < row + width - 1 && data[right + 1] === old) right += 1;
      data.fill(value, left, right + 1);
      for (const next of [-width, width]) {
        for (let one = left + next; one <= right + next; one += 1) {
          if (data[one] === old && (one === left + next || data[one - 1] !== old)) open.push(one);
        }
      }
    }
    return { x: 0, y: 0, width, height };
  }

  /** Show the numbers of a part on the canvas; by default all.
   * @param {Box} [box] */
  paint(box) {
    const { x, y, width, height } = box ?? { x: 0, y: 0, width: this.width, height: this.height };
    if (width <= 0 || height <= 0) return;
    this.version += 1;
    const shown = new ImageData(width, height);
    const pixels = new Uint32Array(shown.data.buffer);
    const { data, known, inks } = this;
    for (let row = y, to = 0; row < y + height; row += 1) {
      const from = row * this.width;
      for (let at = from + x; at < from + x + width; ) {
        const label = data[at] ?? 0;
        const { side, pixels: ink } = inks[label] ?? NONE;
        const line = (row % side) * side;
        for (let u = (at - from) % side; at < from + x + width && data[at] === label; at += 1, to += 1) {
          if (known[at] !== label) pixels[to] = ink[line + u] ?? 0;
          u = u + 1 === side ? 0 : u + 1;
        }
      }
    }
    this.canvas.getContext("2d")?.putImageData(shown, x, y);
  }

  /** Take the numbers of others, as far as they reach.
   * @param {{width: number, height: number, data: Uint8Array}} others */
  lay({ width, height, data }) {
    for (let row = 0; row < Math.min(height, this.height); row += 1) {
      this.data.set(data.subarray(row * width, row * width + Math.min(width, this.width)), row * this.width);
    }
    this.paint();
  }

  /** Which numbers there are. */
  get values() {
    const there = new Uint8Array(256);
    for (const value of this.data) there[value] = 1;
    return [...there.keys()].filter((value) => there[value]);
  }
}
