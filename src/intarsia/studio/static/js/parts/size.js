/** The size of what is grown: width and height, and how often the exemplar fits in. */

import { button, el, follow } from "../core/dom.js";
import { store } from "../core/store.js";

/**
 * @param {string | undefined} told such as 640x480
 * @returns {[string, string]}
 */
function parts(told) {
  const [width = "", height = width] = String(told ?? "").split("x");
  return [width, height];
}

/**
 * @param {import("../core/settings.js").Settings} settings
 * @returns {HTMLElement}
 */
export function sizeField(settings) {
  const twice = (/** @type {"width" | "height"} */ side) => String((store.exemplar?.[side] ?? 0) * 2 || "");
  const field = (/** @type {"width" | "height"} */ side) =>
    el("input", {
      class: "field", type: "number", min: "1", max: "65536", step: "1", inputMode: "numeric",
      "aria-label": side === "width" ? "Width in px" : "Height in px", placeholder: twice(side), oninput: () => told(),
    });
  const wide = field("width");
  const high = field("height");
  const told = () => {
    if (!wide.reportValidity() || !high.reportValidity()) return;
    const asked = wide.value || high.value;
    settings.set("size", asked ? `${wide.value || high.value}x${high.value || wide.value}` : null);
  };
  const show = () => {
    const [width, height] = parts(settings.options.size);
    if (document.activeElement !== wide) wide.value = width;
    if (document.activeElement !== high) high.value = height;
  };
  follow(settings, wide, show);
  const times = (/** @type {number} */ by) => () => {
    const exemplar = store.exemplar;
    if (exemplar) settings.set("size", `${exemplar.width * by}x${exemplar.height * by}`);
  };
  const steps = [2, 3, 4, 8].map((by) => button(`${by}×`, times(by), { "aria-label": `${by} times the exemplar` }));
  return el(
    "div",
    { class: "group" },
    el("div", { class: "row" }, el("span", {}, "Size"), el("span", { class: "joined" }, wide, el("span", { class: "quiet" }, "×"), high)),
    el("div", { class: "row" }, el("span"), el("span", { class: "segments wide" }, steps)),
  );
}
