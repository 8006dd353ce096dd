/** Undo and redo, as buttons. Their keys belong to the frame around all rooms. */

import { button, follow } from "../core/dom.js";
import { icon } from "../core/icons.js";

/** @param {import("../core/past.js").Past} past @returns {HTMLElement[]} */
export function undoButtons(past) {
  const undo = button("Undo", () => past.undo(), { icon: icon("undo"), bare: true, title: "Undo (Ctrl+Z)" });
  const redo = button("Redo", () => past.redo(), { icon: icon("redo"), bare: true, title: "Redo (Ctrl+Shift+Z)" });
  follow(past, undo, () => [(undo.disabled = !past.done.length), (redo.disabled = !past.undone.length)]);
  return [undo, redo];
}
