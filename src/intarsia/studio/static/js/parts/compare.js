/** Two pictures on one stage with a divider between them, moved by pointer and keys. */

import { el } from "../core/dom.js";

export class Compare {
  divider = el("div", {
    class: "divider", role: "slider", tabindex: "0", tabIndex: 0, "aria-label": "Divider between A and B",
    "aria-valuemin": "0", "aria-valuemax": "100", hidden: true,
  });
  left = el("span", { class: "corner left", hidden: true });
  right = el("span", { class: "corner right", hidden: true });

  /** @param {import("../stage/stage.js").Stage} stage */
  constructor(stage) {
    this.stage = stage;
    stage.append(this.divider, this.left, this.right);
    stage.addEventListener("view", () => this.#place());
    this.divider.addEventListener("pointerdown", (e) => {
      e.stopPropagation();
      this.divider.setPointerCapture(e.pointerId);
    });
    this.divider.addEventListener("pointermove", (e) => {
      if (!this.divider.hasPointerCapture(e.pointerId)) return;
      e.stopPropagation();
      const box = stage.getBoundingClientRect();
      const [, wide] = stage.split();
      this.#move(((e.clientX - box.left) * devicePixelRatio - stage.view.x) / wide);
    });
    this.divider.addEventListener("keydown", (e) => {
      const step = { ArrowLeft: -0.02, ArrowRight: 0.02 }[e.key];
      if (!step) return;
      e.preventDefault();
      e.stopPropagation();
      this.#move(stage.divider + step);
    });
  }

  /** Whether two are compared. */
  get on() {
    return this.stage.other !== null;
  }

  /** @param {import("../stage/stage.js").Drawable | null} other to the right of the divider; null ends it
   * @param {string} [left] what is what @param {string} [right] @param {string} [path] of the other one */
  show(other, left = "", right = "", path) {
    this.stage.beside(other, path);
    for (const each of [this.divider, this.left, this.right]) each.hidden = !other;
    this.left.textContent = `A  ${left}`;
    this.right.textContent = `B  ${right}`;
    this.#place();
  }

  /** @param {number} share */
  #move(share) {
    this.stage.divider = Math.max(0, Math.min(1, share));
    this.#place();
    this.stage.draw(true);
  }

  #place() {
    const [left] = this.stage.split();
    this.divider.style.left = `${left / devicePixelRatio}px`;
    this.divider.setAttribute("aria-valuenow", String(Math.round(this.stage.divider * 100)));
  }
}
