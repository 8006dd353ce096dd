/** The tools to paint with: which one, how large; and their keys. */

import { button, el, follow, typing } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { undoButtons } from "../parts/undo.js";

/** @type {{tool: import("./brush.js").Tool, says: string, icon: import("../core/icons.js").IconName, key: string}[]} */
const TOOLS = [
  { tool: "brush", says: "Brush (B)", icon: "brush", key: "b" },
  { tool: "erase", says: "Erase (E)", icon: "erase", key: "e" },
  { tool: "fill", says: "Fill (F)", icon: "fill", key: "f" },
  { tool: "move", says: "Move (H)", icon: "hand", key: "h" },
];

/** @param {import("./brush.js").Kit} kit @returns {HTMLElement} */
export function toolbar(kit) {
  const tools = TOOLS.map(({ tool, says, icon: name }) =>
    button(says, () => kit.set({ tool }), { icon: icon(name), bare: true, value: tool }),
  );
  const size = el("input", {
    class: "range", type: "range", min: "0", max: "100", step: "1", "aria-label": "Size of the brush",
    oninput: () => kit.set({ size: Math.round(512 ** (Number(size.value) / 100)) }),
  });
  const told = el("output", { class: "small quiet number brush-size" });
  const show = () => {
    for (const each of tools) each.setAttribute("aria-pressed", String(each.value === kit.tool));
    if (document.activeElement !== size) size.value = String((100 * Math.log(kit.size)) / Math.log(512));
    told.textContent = `${kit.size} px`;
  };
  follow(kit, size, show);
  return el(
    "div",
    { class: "group", role: "toolbar", "aria-label": "Painting" },
    el("div", { class: "tool-row" }, tools, el("span", { class: "gap" }), undoButtons(kit.past)),
    el("div", { class: "row" }, el("span", {}, "Brush"), el("span", { class: "joined" }, size, told)),
  );
}

/** Keys of the tools, while a room is open.
 * @param {import("./brush.js").Kit} kit @param {AbortSignal} signal @param {number} labels how many there are to choose from by digits */
export function toolKeys(kit, signal, labels) {
  const act = (/** @type {KeyboardEvent} */ e) => {
    if (typing(e) || e.ctrlKey || e.metaKey) return;
    const key = e.key.toLowerCase();
    const tool = TOOLS.find((each) => each.key === key)?.tool;
    if (tool) kit.set({ tool });
    else if (key === "[" || key === "]") kit.set({ size: key === "[" ? Math.min(kit.size - 1, kit.size / 1.2) : kit.size * 1.2 + 1 });
    else if (/^[1-9]$/.test(key) && Number(key) <= labels) kit.set({ value: Number(key) - 1, tool: "brush" });
    else return;
    e.preventDefault();
    e.stopPropagation();
  };
  addEventListener("keydown", act, { signal, capture: true });
}
