/** The stage: one picture, large, on a canvas; zoomed, moved, tiled, with layers over it, or two side by side. */

import { Ground } from "./ground.js";
import { Parts } from "./parts.js";
import { View } from "./view.js";

/** @typedef {ImageBitmap | HTMLCanvasElement | OffscreenCanvas} Drawable */
/** @typedef {{picture: Drawable, alpha?: number}} Layer a picture over the picture, stretched to its size */
/** @typedef {{width: number, height: number}} Size */
/** @typedef {(canvas: Size, view: View, size: Size, tiles: number) => Drawable} Painter */

const MARGIN = 24;
const BLOCKS = 4;

/** @extends {Ground<View>} */
export class Stage extends Ground {
  /** @type {Drawable | null} */ picture = null;
  /** @type {Drawable | null} what is seen to the right of the divider */
  other = null;
  /** @type {[Parts | null, Parts | null]} of the picture and of the other one, where they are larger than what was loaded */
  parts = [null, null];
  /** Whether the picture is a draft of one whose size is not known yet. */
  draft = false;
  divider = 0.5;
  /** px of the picture that are left free on each side, for what is drawn around it. */
  around = 0;
  /** @type {number} how often it is drawn along each axis */
  tiles = 1;
  /** @type {Layer[]} */ layers = [];
  /** @type {Painter | null} draws the picture in another way, as large as the stage */
  painter = null;
  /** @type {((pen: CanvasRenderingContext2D, view: View) => void) | null} draws marks, in device pixels */
  marks = null;
  #width = 0;
  #height = 0;
  #rest = 0;

  constructor() {
    super(new View());
    this.addEventListener("pointermove", (e) => this.#hover(e));
    this.addEventListener("pointerleave", () => this.dispatchEvent(new CustomEvent("hover", { detail: null })));
  }

  /** Show a picture. The view stays where the size is the same.
   * @param {Drawable | null} picture @param {string} [name] what it is, for those who do not see it
   * @param {[number, number]} [size] that it stands for, where what was loaded is smaller @param {string} [path] where its parts are then */
  show(picture, name = "", size, path) {
    const [width, height] = size ?? [picture?.width ?? 0, picture?.height ?? 0];
    const same = width === this.#width && height === this.#height;
    this.picture = picture;
    [this.#width, this.#height] = [width, height];
    this.parts = [this.#partsOf(picture, path), null];
    this.canvas.setAttribute("aria-label", name);
    if (!same) this.fit();
    this.redraw();
  }

  /** Show another picture of the same size to the right of the divider; null: none.
   * @param {Drawable | null} picture @param {string} [path] where its parts are */
  beside(picture, path) {
    this.other = picture;
    this.parts[1] = this.#partsOf(picture, path);
    this.draw();
  }

  /** @param {Drawable | null} picture @param {string} [path] */
  #partsOf(picture, path) {
    const reduced = path && picture && picture.width < this.#width;
    return reduced ? new Parts(path, this.#width, this.#height, () => this.draw()) : null;
  }

  /** Size of the picture in its own pixels. */
  get size() {
    return { width: this.#width, height: this.#height };
  }

  /** Show all of it, all its tiles as well. */
  fit() {
    const most = this.tiles > 1 ? 1 : BLOCKS;
    const { width, height } = this.canvas;
    const [wide, high] = [this.#width, this.#height].map((side) => side * this.tiles + 2 * this.around || 1);
    this.view.fit(wide ?? 1, high ?? 1, width, height, MARGIN * devicePixelRatio, most);
    this.view.x += Math.round(this.around * this.view.scale);
    this.view.y += Math.round(this.around * this.view.scale);
    this.redraw();
  }

  /** @param {number} tiles along each axis */
  tile(tiles) {
    this.tiles = tiles;
    this.fit();
  }

  /** Draw at the next frame.
   * @param {boolean} [moving] then what is far is drawn quickly, and well once it rests */
  draw(moving = false) {
    clearTimeout(this.#rest);
    if (moving) this.#rest = window.setTimeout(() => this.draw(), 120);
    this.next(() => this.#draw(moving));
  }

  resized() {
    if (this.view.fitted) this.fit();
    this.#draw(false);
  }

  /** @param {boolean} moving */
  #draw(moving) {
    const pen = this.canvas.getContext("2d");
    if (!pen) return;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (!this.picture) return;
    pen.imageSmoothingEnabled = this.view.scale < 2;
    pen.imageSmoothingQuality = moving ? "low" : "high";
    if (this.painter) pen.drawImage(this.painter(this.canvas, this.view, this.size, this.tiles), 0, 0);
    else this.#tiles(pen, this.picture, this.parts[0]);
    if (this.other) {
      const [left] = this.split();
      pen.save();
      pen.beginPath();
      pen.rect(left, 0, this.canvas.width, this.canvas.height);
      pen.clip();
      this.#tiles(pen, this.other, this.parts[1]);
      pen.restore();
    }
    for (const layer of this.layers) {
      pen.globalAlpha = layer.alpha ?? 1;
      this.#tiles(pen, layer.picture);
      pen.globalAlpha = 1;
    }
    this.marks?.(pen, this.view);
  }

  /** Draw a picture once for each tile, each from one whole device pixel to another, so that no gap shows.
   * @param {CanvasRenderingContext2D} pen @param {Drawable} picture @param {Parts | null} [parts] of it */
  #tiles(pen, picture, parts) {
    const { scale, x, y } = this.view;
    const wide = this.#width * scale;
    const high = this.#height * scale;
    for (let row = 0; row < this.tiles; row += 1) {
      const top = Math.round(y + row * high);
      const below = Math.round(y + (row + 1) * high);
      if (below < 0 || top > this.canvas.height) continue;
      for (let column = 0; column < this.tiles; column += 1) {
        const left = Math.round(x + column * wide);
        const right = Math.round(x + (column + 1) * wide);
        if (right < 0 || left > this.canvas.width) continue;
        pen.drawImage(picture, left, top, Math.max(1, right - left), Math.max(1, below - top));
        if (wide > picture.width) parts?.draw(pen, left, top, scale);
      }
    }
  }

  /** @returns {[number, number]} where the divider stands, and how wide all tiles are, in device pixels */
  split() {
    const wide = this.#width * this.view.scale * this.tiles;
    return [this.view.x + wide * this.divider, wide];
  }

  /** @param {PointerEvent} event */
  #hover(event) {
    const box = this.getBoundingClientRect();
    const ratio = devicePixelRatio;
    const { scale } = this.view; // the picture is drawn from a whole pixel on
    const x = ((event.clientX - box.left) * ratio - Math.round(this.view.x)) / scale;
    const y = ((event.clientY - box.top) * ratio - Math.round(this.view.y)) / scale;
    const inside = x >= 0 && y >= 0 && x < this.#width * this.tiles && y < this.#height * this.tiles;
    const place = inside ? { x: Math.floor(x) % this.#width, y: Math.floor(y) % this.#height } : null;
    this.dispatchEvent(new CustomEvent("hover", { detail: place }));
  }
}

customElements.define("studio-stage", Stage);
