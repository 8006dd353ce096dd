/** The size of what is grown: so often the exemplar, whichever that is, or width and height where they are typed. */

import { button, el, follow } from "../core/dom.js";
import { store } from "../core/store.js";

const USUAL = 2;

/** How often the exemplar a size is; 0 where it is told in px.
 * @param {string | undefined} told such as 3x, or 640x480 */
function timesOf(told) {
  const found = /^(\d+)x$/.exec(told ?? `${USUAL}x`);
  return found ? Number(found[1]) : 0;
}

/** The size that is asked for of the exemplar that is worked with.
 * @param {import("../core/types.js").Options} options @returns {[number, number]} */
export function pixelsOf({ size }) {
  const times = timesOf(size);
  const { width, height } = store.exemplar ?? { width: 256, height: 256 };
  if (times) return [times * width, times * height];
  const [wide, high] = String(size).split("x").map(Number);
  return [wide || 1, high || wide || 1];
}

/** Options as they are sent: a size in px, as long as it is not the usual one.
 * @param {import("../core/types.js").Options} options */
export function inPixels(options) {
  return options.size ? { ...options, size: pixelsOf(options).join("x") } : options;
}

/** @param {import("../core/settings.js").Settings} settings @returns {HTMLElement} */
export function sizeField(settings) {
  const field = (/** @type {"width" | "height"} */ side) =>
    el("input", {
      class: "field", type: "number", min: "1", max: "65536", step: "1", inputMode: "numeric",
      "aria-label": side === "width" ? "Width in px" : "Height in px", oninput: () => told(),
    });
  const wide = field("width");
  const high = field("height");
  const told = () => {
    if (!wide.reportValidity() || !high.reportValidity()) return;
    settings.set("size", [wide.value, high.value].filter(Boolean).join("x") || null);
  };
  const steps = [2, 3, 4, 8].map((by) =>
    button(`${by}×`, () => choose(by), { "aria-label": `${by} times the example`, value: String(by) }),
  );
  const choose = (/** @type {number} */ by) => {
    wide.value = high.value = "";
    settings.set("size", by === USUAL ? null : `${by}x`);
    show();
  };
  const show = () => {
    const times = timesOf(settings.options.size);
    const sides = pixelsOf(settings.options).map(String);
    const one = !String(settings.options.size).includes("x"); // the other side follows the one that is typed
    [wide, high].forEach((input, n) => {
      input.placeholder = sides[n] ?? "";
      const follows = times || (one && input !== (document.activeElement === high ? high : wide));
      if (document.activeElement !== input) input.value = follows ? "" : input.placeholder;
    });
    for (const each of steps) each.setAttribute("aria-pressed", String(Number(each.value) === times));
  };
  follow(settings, wide, show);
  follow(store, wide, show, "exemplar");
  return el(
    "div",
    { class: "group" },
    el("div", { class: "row" }, el("span", {}, "Size"), el("span", { class: "joined" }, wide, el("span", { class: "quiet" }, "×"), high)),
    el("div", { class: "row" }, el("span"), el("span", { class: "segments wide" }, steps)),
  );
}
