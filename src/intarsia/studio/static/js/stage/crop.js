/** A rectangle drawn over the stage with whole pixels as its corners. */

export class Crop {
  /** @type {{x: number, y: number, width: number, height: number} | null} */ box = null;
  /** @type {[number, number] | null} */ #from = null;

  /** @param {import("./stage.js").Stage} stage @param {() => void} changed */
  constructor(stage, changed) {
    this.stage = stage;
    this.changed = changed;
  }

  /** @type {import("./gestures.js").Stroke["down"]} */
  down(x, y) {
    this.#from = [x, y];
    this.box = null;
    return true;
  }

  /** @type {import("./gestures.js").Stroke["move"]} */
  move(x, y) {
    if (!this.#from) return;
    const { width, height } = this.stage.size;
    const inside = (/** @type {number} */ v, /** @type {number} */ most) => Math.max(0, Math.min(most, Math.round(v)));
    const [ax, bx] = [inside(this.#from[0], width), inside(x, width)];
    const [ay, by] = [inside(this.#from[1], height), inside(y, height)];
    const box = { x: Math.min(ax, bx), y: Math.min(ay, by), width: Math.abs(ax - bx), height: Math.abs(ay - by) };
    this.box = box.width && box.height ? box : null;
    this.stage.draw();
    this.changed();
  }

  up() {
    this.#from = null;
  }

  stop() {
    this.#from = null;
  }

  /** @type {NonNullable<import("./stage.js").Stage["marks"]>} */
  marks(pen, view) {
    if (!this.box) return;
    const { width, height } = this.stage.size;
    const at = (/** @type {number} */ x, /** @type {number} */ y) =>
      /** @type {[number, number]} */ ([Math.round(view.x + x * view.scale), Math.round(view.y + y * view.scale)]);
    const [left, top] = at(this.box.x, this.box.y);
    const [right, below] = at(this.box.x + this.box.width, this.box.y + this.box.height);
    pen.fillStyle = "rgb(0 0 0 / 60%)";
    pen.beginPath();
    const [whole, far] = [at(0, 0), at(width, height)];
    pen.rect(...whole, far[0] - whole[0], far[1] - whole[1]);
    pen.rect(left, top, right - left, below - top);
    pen.fill("evenodd");
    pen.lineWidth = devicePixelRatio;
    pen.strokeStyle = "#ffffff";
    pen.strokeRect(left - 0.5, top - 0.5, right - left + 1, below - top + 1);
  }
}
