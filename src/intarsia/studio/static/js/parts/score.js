/** How good a result is: in words, with what takes most away from it, and where that is. */

import { get } from "../core/api.js";
import { button, el, fill } from "../core/dom.js";
import { tried } from "../core/toast.js";
import { judged } from "../core/words.js";
import { menu } from "./menu.js";

/** @typedef {import("./places.js").Spot} Spot */

/** @type {Record<string, [string, string]>} parts of the score: what such flaws are called, and what is seen */
const FLAWS = {
  texture: ["differences", "It looks like another texture"],
  joins: ["seams", "Seams show"],
  steps: ["uneven tone", "Light or colour changes at seams"],
  overused: ["repeats", "Some places of the example are shown too often"],
  salient: ["repeats", "What stands out is seen again and again"],
  repeats: ["repeats", "The same things are seen again near by"],
  lattice: ["slips", "Rows or grid lines are out of step"],
  blurred: ["blur", "It is less sharp than the example"],
};

/** What is wrong in a part, and in how many places.
 * @param {string} part @param {number} count */
function sentence(part, count) {
  const most = part === "joins" ? `, most in ${count} ${count > 1 ? "places" : "place"}` : `, one of them ${count} times`;
  return `${FLAWS[part]?.[1] ?? part}${count ? most : ""}`;
}

/** A button that says how good a result is, and opens a list of what takes most away.
 * @param {import("../core/types.js").Result} result
 * @param {(part: string, says: string, spots: Spot[]) => void} show marks places of a part @returns {HTMLElement | null} */
export function scoreButton({ id, score }, show) {
  if (!score) return null;
  const parts = Object.entries(score.parts).filter(([, part]) => part.loss >= 0.5).sort(([, a], [, b]) => b.loss - a.loss);
  const says = (score.parts.texture?.worth ?? 1) < 0.5 ? "Another texture" : judged(score.total, FLAWS[parts[0]?.[0] ?? ""]?.[0]);
  const total = String(Math.round(score.total));
  const box = el("div", { class: "menu score", role: "group", "aria-label": "What takes most away", tabIndex: 0 });
  const list = (/** @type {Record<string, Spot[]>} */ places) =>
    parts.map(([part, { loss }]) => {
      const found = places[part] ?? [];
      const spots = found.length > 1 || part === "joins" ? found : []; // what is seen once is not seen again
      const told = sentence(part, spots.length);
      const shows = spots.length > 0 && button("Show", () => show(part, told, spots), { class: "framed", "aria-label": `Show: ${told}` });
      return el("li", {}, el("span", {}, told), el("span", { class: "number quiet" }, `−${Math.round(loss)}`), shows);
    });
  const draw = (/** @type {Record<string, Spot[]>} */ places, /** @type {string} */ more = "") =>
    fill(box, el("p", { class: "quiet small" }, `${total} of 100; 100 is as good as the example itself.${more}`), el("ul", {}, list(places)));
  const toggle = button(says, () => {}, { "aria-label": `${says}, score ${total}` });
  toggle.append(el("span", { class: "quiet small number" }, `${total}/100`));
  let asked = false;
  return menu(toggle, box, () => {
    if (asked) return;
    asked = true;
    draw({}, " Looking where …");
    void tried(() => get(`/api/results/${id}/places`)).then((places) => [(asked = Boolean(places)), draw(places ?? {})]);
  });
}
