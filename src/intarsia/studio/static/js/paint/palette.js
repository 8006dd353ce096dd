/** The labels to paint with: of each what it looks like, its number, and the name that it was given. */

import { el, follow } from "../core/dom.js";
import { kept } from "../core/kept.js";
import { store } from "../core/store.js";
import { COLOURS } from "./labels.js";

export const LABELS = 6;

/** What a label is called; "" as long as it has no name.
 * @param {number} n */
const given = (n) => kept.of(store.exemplar?.id).names?.[n] ?? "";

/** @param {number} n */
export const nameOf = (n) => given(n) || `Label ${n + 1}`;

/** @param {import("./brush.js").Kit} kit
 * @returns {{element: HTMLElement, dip: (inks: import("./labels.js").Ink[]) => void}} `dip`: show what labels look like */
export function palette(kit) {
  const cells = COLOURS.slice(0, LABELS).map(([r, g, b], n) => {
    const look = el("canvas");
    const number = el("span", { class: "swatch", style: `background: rgb(${r} ${g} ${b})` }, n + 1);
    const choose = () => kit.set({ value: n, tool: kit.tool === "fill" ? "fill" : "brush" });
    const swatch = el("button", { type: "button", class: "button", onclick: choose }, look, number);
    const name = el("input", {
      class: "field", maxLength: 24, placeholder: `Label ${n + 1}`, title: "Its name", "aria-label": `Name of label ${n + 1}`,
      onchange: () => call(n, name.value.trim()), onkeydown: (/** @type {KeyboardEvent} */ e) => e.key === "Enter" && name.blur(),
    });
    return { look, swatch, name };
  });
  const call = (/** @type {number} */ n, /** @type {string} */ name) => {
    const [id, before] = [store.exemplar?.id, given(n)];
    const named = (/** @type {string} */ now) => kept.set({ names: { ...kept.of(id).names, [n]: now } }, id);
    kit.history.add({ labels: null, back: () => named(before), again: () => named(name) }, true);
  };
  const show = () => cells.forEach(({ swatch, name }, n) => {
    swatch.setAttribute("aria-pressed", String(n === kit.value));
    swatch.ariaLabel = nameOf(n);
    swatch.title = `${nameOf(n)} (${n + 1})`;
    if (document.activeElement !== name) name.value = given(n);
  });
  const element = el("div", { class: "palette" }, cells.map(({ swatch, name }) => el("div", { class: "label-cell" }, swatch, name)));
  follow(kit, element, show);
  follow(store, element, show, "exemplar");
  return { element, dip: (inks) => inks.slice(0, LABELS).forEach(({ side, pixels }, n) => {
    const look = cells[n]?.look;
    if (!look) return;
    look.width = look.height = side;
    look.getContext("2d")?.putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer), side), 0, 0);
  }) };
}
