/** A few choices side by side, one of which holds: a radio group, walked through by arrow keys. */

import { el } from "../core/dom.js";

/** @template {string} T
 * @param {string} name of the group @param {[T, string][]} choices value and what it says
 * @param {() => T} now @param {(value: T) => void} choose
 * @param {{wide?: boolean}} [look] @returns {{element: HTMLElement, show: () => void}} */
export function segments(name, choices, now, choose, look = {}) {
  const buttons = choices.map(([value, says]) =>
    el("button", { type: "button", class: "button", role: "radio", value, onclick: () => take(value) }, says),
  );
  const group = el("div", {
    class: `segments ${look.wide ? "wide" : ""}`, role: "radiogroup", "aria-label": name, onkeydown: (/** @type {KeyboardEvent} */ e) => walk(e),
  }, buttons);
  const show = () => {
    const value = now();
    for (const each of buttons) {
      each.setAttribute("aria-checked", String(each.value === value));
      each.tabIndex = each.value === value ? 0 : -1;
    }
    if (!buttons.some((each) => each.tabIndex === 0) && buttons[0]) buttons[0].tabIndex = 0;
  };
  const take = (/** @type {T} */ value) => {
    choose(value);
    show();
  };
  const walk = (/** @type {KeyboardEvent} */ event) => {
    const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const at = choices.findIndex(([value]) => value === now());
    const next = (at + step + choices.length) % choices.length;
    const chosen = choices[next];
    if (chosen) take(chosen[0]);
    buttons[next]?.focus();
  };
  show();
  return { element: group, show };
}
