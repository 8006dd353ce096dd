/** What is seen of an endless canvas: tiles where the view lies, moved and zoomed for ever. */

import { Ground } from "../stage/ground.js";
import { View } from "../stage/view.js";
import { SIDE } from "./tiles.js";

const LEVELS = 4;
const MOST = 16;

/** A view that goes on for ever, and shows no more at once than can be drawn. */
export class FarView extends View {
  fitted = false;

  /** @param {number} scale @param {number} x @param {number} y */
  zoom(scale, x, y) {
    super.zoom(Math.max(2 ** (1 - LEVELS), Math.min(MOST, scale)), x, y);
  }

  /** Of tiles this much reduced there is a pixel for a pixel at least. */
  get level() {
    return Math.max(0, Math.min(LEVELS - 1, Math.floor(Math.log2(1 / this.scale) + 1e-6)));
  }
}

/** @extends {Ground<FarView>} */
export class Sight extends Ground {
  #begun = false;
  /** @type {{picture: ImageBitmap, width: number} | null} the example, and how wide it is: it is seen until tiles come */
  ground = null;

  /** @param {import("./tiles.js").Tiles} tiles @param {FarView} view */
  constructor(tiles, view) {
    super(view);
    this.tiles = tiles;
  }

  connectedCallback() {
    super.connectedCallback();
    this.gone = new AbortController();
    this.tiles.addEventListener("change", () => this.draw(), { signal: this.gone.signal });
  }

  disconnectedCallback() {
    super.disconnectedCallback();
    this.gone?.abort();
    this.tiles.stop();
  }

  /** @param {string} name what is seen, for those who do not see it */
  call(name) {
    this.canvas.setAttribute("aria-label", name);
  }

  /** @param {number} wide @param {number} high */
  resized(wide, high) {
    if (this.#begun) this.view.move((this.canvas.width - wide) / 2, (this.canvas.height - high) / 2);
    else if (this.view.x === 0 && this.view.y === 0) this.fit();
    this.#begun = true;
    this.#draw();
    this.look();
  }

  /** Go to where it begins, a pixel for a pixel. */
  fit() {
    this.view.scale = 1;
    this.view.x = Math.round(this.canvas.width / 2);
    this.view.y = Math.round(this.canvas.height / 2);
    this.redraw();
  }

  /** Draw at the next frame, and ask for what is then in sight. */
  draw() {
    this.next(() => [this.look(), this.#draw()]);
  }

  /** @returns {{x: number, y: number, width: number, height: number}} what is in sight, in whole px of the canvas */
  get window() {
    const [left, top] = this.view.at(0, 0);
    const [right, below] = this.view.at(this.canvas.width, this.canvas.height);
    const [x, y] = [Math.floor(left + 1e-6), Math.floor(top + 1e-6)];
    return { x, y, width: Math.max(1, Math.ceil(right - 1e-6) - x), height: Math.max(1, Math.ceil(below - 1e-6) - y) };
  }

  /** @returns {import("./tiles.js").Place[]} tiles in sight, nearest first */
  get places() {
    const { level } = this.view;
    const side = SIDE << level;
    const { x, y, width, height } = this.window;
    const [u, v] = [x + width / 2, y + height / 2];
    /** @type {(import("./tiles.js").Place & {far: number})[]} */ const found = [];
    for (let row = Math.floor(y / side); row * side < y + height; row += 1) {
      for (let column = Math.floor(x / side); column * side < x + width; column += 1) {
        found.push({ level, y: row, x: column, far: Math.hypot((column + 0.5) * side - u, (row + 0.5) * side - v) });
      }
    }
    return found.sort((a, b) => a.far - b.far);
  }

  /** Ask for what is in sight. */
  look() {
    if (this.isConnected) this.tiles.want(this.places);
  }

  #draw() {
    const pen = this.canvas.getContext("2d");
    if (!pen) return;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.imageSmoothingEnabled = this.view.scale < 2;
    pen.imageSmoothingQuality = "low";
    const places = this.places;
    if (places.some((place) => !this.tiles.get(place))) {
      this.#ground(pen);
      for (const tile of this.tiles.former.values()) this.#tile(pen, tile);
      this.#others(pen, this.view.level);
    }
    for (const place of places) {
      const tile = this.tiles.get(place);
      if (tile) this.#tile(pen, tile);
    }
    this.dispatchEvent(new Event("drawn"));
  }

  /** The example again and again, dim, as nothing of this texture is there yet.
   * @param {CanvasRenderingContext2D} pen */
  #ground(pen) {
    const pattern = this.ground && pen.createPattern(this.ground.picture, "repeat");
    if (!this.ground || !pattern) return;
    const scale = (this.view.scale * this.ground.width) / this.ground.picture.width;
    pattern.setTransform(new DOMMatrix([scale, 0, 0, scale, this.view.x, this.view.y]));
    pen.fillStyle = pattern;
    pen.globalAlpha = 0.4;
    pen.fillRect(0, 0, this.canvas.width, this.canvas.height);
    pen.globalAlpha = 1;
  }

  /** What is known of other levels, until what is wanted comes: coarser ones first, finer ones over them.
   * @param {CanvasRenderingContext2D} pen @param {number} level */
  #others(pen, level) {
    const others = [...this.tiles.held].filter((tile) => tile.level !== level);
    for (const tile of others.sort((a, b) => b.level - a.level)) this.#tile(pen, tile);
  }

  /** Draw a tile from one whole device pixel to another, so that no gap shows.
   * @param {CanvasRenderingContext2D} pen @param {import("./tiles.js").Tile} tile */
  #tile(pen, { picture, level, y, x }) {
    const { scale } = this.view;
    const side = SIDE * 2 ** level * scale;
    const [left, top] = [Math.round(this.view.x + x * side), Math.round(this.view.y + y * side)];
    const [right, below] = [Math.round(this.view.x + (x + 1) * side), Math.round(this.view.y + (y + 1) * side)];
    if (right < 0 || below < 0 || left > this.canvas.width || top > this.canvas.height) return;
    pen.drawImage(picture, left, top, right - left, below - top);
  }
}

customElements.define("endless-sight", Sight);
