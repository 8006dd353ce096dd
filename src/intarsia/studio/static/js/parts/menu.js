/** A button that opens a box below itself; it closes when the focus leaves both, and by Escape. */

import { el } from "../core/dom.js";

/** @param {HTMLButtonElement} toggle @param {HTMLElement} box @param {() => void} [opened] @returns {HTMLElement} both */
export function menu(toggle, box, opened) {
  const open = (/** @type {boolean} */ yes) => {
    box.hidden = !yes;
    toggle.setAttribute("aria-expanded", String(yes));
    if (yes) opened?.();
  };
  open(false);
  toggle.addEventListener("click", () => open(box.hidden));
  const around = el("span", { class: "around" }, toggle, box);
  around.addEventListener("focusout", (e) => (e.relatedTarget instanceof Node && around.contains(e.relatedTarget)) || open(false));
  box.addEventListener("click", (e) => e.target instanceof Element && e.target.closest("a") && open(false)); // it was taken
  around.addEventListener("keydown", (e) => e.key === "Escape" && [open(false), toggle.focus()]);
  return around;
}
