/** The axes along which what is grown continues in itself. */

import { follow } from "../core/dom.js";
import { segments } from "./choice.js";

/** @type {[string, string][]} */
const AXES = [["none", "No"], ["x", "Across"], ["y", "Down"], ["both", "Both"]];

/** @param {import("../core/settings.js").Settings} settings @returns {{element: HTMLElement, show: () => void}} */
export function wrapChoice(settings) {
  const now = () => settings.options.wrap ?? "none";
  const choice = segments("Tiles", AXES, now, (axes) => settings.set("wrap", axes === "none" ? null : axes), { wide: true });
  follow(settings, choice.element, choice.show);
  return choice;
}
