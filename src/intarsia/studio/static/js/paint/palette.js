/** The labels to paint with: of each what it looks like, its number, and the name that it was given. */

import { el, follow } from "../core/dom.js";
import { kept } from "../core/kept.js";
import { store } from "../core/store.js";
import { COLOURS } from "./labels.js";

export const LABELS = 6;

/** What a label is called.
 * @param {number} n */
export function nameOf(n) {
  return names()[n] || `Label ${n + 1}`;
}

/** @returns {Record<number, string>} names that were given for this exemplar */
function names() {
  return kept.of(store.exemplar?.id).names ?? {};
}

export class Palette {
  /** @param {import("./brush.js").Kit} kit */
  constructor(kit) {
    this.kit = kit;
    this.cells = COLOURS.slice(0, LABELS).map((colour, n) => this.#cell(colour, n));
    this.element = el("div", { class: "palette" }, this.cells.map(({ swatch, name }) => el("div", { class: "label-cell" }, swatch, name)));
    follow(kit, this.element, () => this.#show());
    follow(store, this.element, () => this.#show(), "exemplar");
  }

  /** @param {number[]} colour @param {number} n */
  #cell([r, g, b], n) {
    const look = el("canvas");
    const number = el("span", { class: "swatch" }, n + 1);
    number.style.background = `rgb(${r} ${g} ${b})`;
    const choose = () => this.kit.set({ value: n, tool: this.kit.tool === "fill" ? "fill" : "brush" });
    const swatch = el("button", { type: "button", class: "button", onclick: choose }, look, number);
    const name = el("input", {
      class: "field", maxLength: 24, placeholder: `Label ${n + 1}`, title: "Its name", "aria-label": `Name of label ${n + 1}`, autocomplete: "off",
      onchange: () => this.#call(n, name.value.trim()), onkeydown: (/** @type {KeyboardEvent} */ e) => e.key === "Enter" && name.blur(),
    });
    return { look, swatch, name };
  }

  /** Show what labels look like.
   * @param {import("./labels.js").Ink[]} inks */
  dip(inks) {
    this.cells.forEach(({ look }, n) => {
      const { side, pixels } = inks[n] ?? { side: 1, pixels: new Uint32Array(1) };
      look.width = look.height = Math.ceil(side / 2); // without its mirror images
      look.getContext("2d")?.putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer), side), 0, 0);
    });
  }

  /** @param {number} n @param {string} name that is given to a label */
  #call(n, name) {
    const id = store.exemplar?.id;
    const before = names()[n] ?? "";
    if (!id || name === before) return;
    const call = (/** @type {string} */ now) => kept.set({ names: { ...kept.of(id).names, [n]: now } }, id);
    call(name);
    this.kit.history.add({ labels: null, back: () => call(before), again: () => call(name) });
  }

  #show() {
    this.cells.forEach(({ swatch, name }, n) => {
      swatch.setAttribute("aria-pressed", String(n === this.kit.value));
      swatch.ariaLabel = nameOf(n);
      swatch.title = `${nameOf(n)} (${n + 1})`;
      if (document.activeElement !== name) name.value = names()[n] ?? "";
    });
  }
}
