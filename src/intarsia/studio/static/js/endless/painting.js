/** What can be set of the brush of jitter: its tools, how strong it is, and what holds where nothing was painted. */

import { button, el, follow } from "../core/dom.js";
import { toolbar } from "../paint/tools.js";

/** @typedef {import("./strokes.js").Strokes} Strokes */

/**
 * @param {Strokes} strokes
 * @returns {HTMLElement}
 */
export function brushFields(strokes) {
  const clear = button("Clear", () => strokes.clear(), { class: "framed" });
  const shown = el("input", {
    class: "switch", type: "checkbox", role: "switch", id: "strokes-shown",
    onchange: () => [(strokes.shown = shown.checked), strokes.tell()],
  });
  const strength = share("Jitter", () => strokes.strength, (value) => [(strokes.strength = value), strokes.tell()], strokes);
  const ground = share("Elsewhere", () => strokes.painted.ground, (value) => strokes.level(value), strokes);
  follow(strokes, clear, () => {
    clear.disabled = !strokes.painted.strokes.length;
    shown.checked = strokes.shown;
  });
  return el(
    "div",
    { class: "group" },
    toolbar(strokes, ["fill"]),
    strength,
    ground,
    el("div", { class: "row strokes-shown" }, el("label", { for: "strokes-shown" }, "Strokes"), el("span", { class: "joined" }, shown, clear)),
  );
}

/**
 * A share of the jitter, as a slider.
 * @param {string} says
 * @param {() => number} now
 * @param {(value: number) => void} set
 * @param {Strokes} strokes
 */
function share(says, now, set, strokes) {
  const id = `share-${says.toLowerCase()}`;
  const told = el("output", { class: "small quiet number brush-size", for: id });
  const input = el("input", {
    class: "range", type: "range", id, min: "0", max: "100", step: "5", oninput: () => set(Number(input.value) / 100),
  });
  follow(strokes, input, () => {
    if (document.activeElement !== input) input.value = String(Math.round(100 * now()));
    told.textContent = `${Math.round(100 * now())} %`;
  });
  return el("div", { class: "row" }, el("label", { for: id }, says), el("span", { class: "joined" }, input, told));
}
