/** A canvas as large as its element, moved and zoomed by gestures and keys: what a stage and the endless sight have in common. */

import { el } from "../core/dom.js";
import { Gestures } from "./gestures.js";

/** @template {import("./view.js").View} V */
export class Ground extends HTMLElement {
  canvas = el("canvas", { role: "img" });
  /** @type {import("./gestures.js").Stroke | null} */ tool = null;
  #asked = 0;

  /** @param {V} view */
  constructor(view) {
    super();
    this.view = view;
    this.gestures = new Gestures(this);
  }

  connectedCallback() {
    this.gestures.listen();
    this.classList.add("stage");
    this.tabIndex = 0;
    if (!this.canvas.isConnected) this.prepend(this.canvas);
    this.observer = new ResizeObserver(() => this.#resize());
    this.observer.observe(this);
  }

  disconnectedCallback() {
    this.observer?.disconnect();
    cancelAnimationFrame(this.#asked);
    this.#asked = 0;
  }

  #resize() {
    const { width, height } = this.canvas;
    this.canvas.width = Math.max(1, Math.round(this.clientWidth * devicePixelRatio));
    this.canvas.height = Math.max(1, Math.round(this.clientHeight * devicePixelRatio));
    this.resized(width, height);
  }

  /** @param {() => void} act what is done at the next frame, once */
  next(act) {
    this.#asked ||= requestAnimationFrame(() => {
      this.#asked = 0;
      act();
    });
  }

  /** The view is another one.
   * @param {boolean} [moving] and it goes on changing */
  redraw(moving) {
    this.draw(moving);
    this.dispatchEvent(new Event("view"));
  }

  /** A pixel for a pixel, the middle where it was. */
  whole() {
    this.view.zoom(1, this.canvas.width / 2, this.canvas.height / 2);
    this.view.x = Math.round(this.view.x);
    this.view.y = Math.round(this.view.y);
    this.redraw();
  }

  /** Show all of it, or where it begins. */
  fit() {}

  /** @param {boolean} [_moving] */
  draw(_moving) {}

  /** @param {number} _wide the canvas was @param {number} _high */
  resized(_wide, _high) {}
}
