/** Numbers painted over a picture: one whole number a pixel, never a mixture of two. A canvas shows them; it decides nothing. */

/** Colours of labels, far enough from each other for most eyes; red, green, blue. */
export const COLOURS = [
  [122, 122, 122], [230, 110, 60], [70, 150, 220], [240, 205, 70], [90, 180, 110], [190, 110, 200], [60, 190, 190],
  [200, 70, 100],
].map((colour) => /** @type {[number, number, number]} */ (colour));

/** @typedef {{x: number, y: number, width: number, height: number}} Box */

export class Labels {
  /** @param {number} width @param {number} height @param {boolean} [ground] whether the number 0 is seen, too */
  constructor(width, height, ground = false) {
    this.width = width;
    this.height = height;
    this.ground = ground;
    this.data = new Uint8Array(width * height);
    this.canvas = new OffscreenCanvas(width, height);
    this.paint({ x: 0, y: 0, width, height });
  }

  /**
   * Give a number to all pixels whose middle lies within `radius` of a line: a stroke of a round, hard brush.
   * @param {[number, number]} from
   * @param {[number, number]} to
   * @param {number} radius
   * @param {number} value
   * @returns {Box} what may have changed
   */
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

  /** Show the numbers of a part on the canvas.
   * @param {Box} box */
  paint({ x, y, width, height }) {
    if (width <= 0 || height <= 0) return;
    const shown = new ImageData(width, height);
    const pixels = new Uint32Array(shown.data.buffer);
    const tints = COLOURS.map(([r, g, b]) => ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0);
    if (!this.ground) tints[0] = 0;
    for (let row = 0; row < height; row += 1) {
      const from = (y + row) * this.width + x;
      for (let column = 0; column < width; column += 1) {
        pixels[row * width + column] = tints[this.data[from + column] ?? 0] ?? 0;
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
    this.paint({ x: 0, y: 0, width: this.width, height: this.height });
  }

  /** Which numbers there are. */
  get values() {
    return [...new Set(this.data)].sort((a, b) => a - b);
  }
}
