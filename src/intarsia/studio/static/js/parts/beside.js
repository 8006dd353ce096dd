/** An editor, and in its place the result once there is one: what the rooms have in common that draw before they grow. */

import { button, el } from "../core/dom.js";
import { store } from "../core/store.js";
import { ResultView } from "./result-view.js";

/**
 * @param {HTMLElement} editor
 * @param {string} name of the way back
 * @param {AbortSignal} signal
 * @returns {{main: HTMLElement, back: HTMLElement, close: () => void}}
 */
export function beside(editor, name, signal) {
  const result = new ResultView();
  const close = () => store.look(null);
  const back = button(name, close, { class: "framed big" });
  store.look(null);
  const turn = () => {
    const seen = store.chosen !== null;
    result.hidden = back.hidden = !seen;
    editor.hidden = seen;
  };
  store.on(["chosen"], turn, signal);
  return { main: el("div", { class: "paint-main" }, editor, result), back, close };
}
