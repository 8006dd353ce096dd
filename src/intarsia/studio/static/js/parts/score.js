/** The score of a result, and the parts that it is made of, when somebody asks. */

import { button, el, fill } from "../core/dom.js";
import { facts, readable } from "../core/words.js";

/** @typedef {import("../core/types.js").Part} Part */

/** @type {Record<string, string>} */
const MEANS = {
  texture: "by how much it is another texture",
  joins: "what changes where pieces meet",
  steps: "slow tone that changes where pieces meet",
  overused: "how often the most used places are shown",
  salient: "how often what stands out is shown",
  repeats: "windows shown again near by with what is around them",
  lattice: "by how much less it repeats in the steps of the example",
  blurred: "by how much steps between neighbours are smaller",
};

/** A button that says the score, and shows its parts.
 * @param {import("../core/types.js").Score | null} score @returns {HTMLElement | null} */
export function scoreButton(score) {
  if (!score) return null;
  const parts = Object.entries(score.parts).sort(([, a], [, b]) => b.loss - a.loss);
  const box = el("div", { class: "menu score", hidden: true, role: "group", "aria-label": "Parts of the score", tabIndex: 0 });
  fill(
    box,
    el("p", { class: "quiet small" }, "100 is as good as the example itself; each part takes something away."),
    el("dl", {}, parts.map(([name, part]) => row(name, part))),
  );
  const toggle = button(facts(`Score ${Math.round(score.total)}`, score.verdict), () => open(box.hidden), { "aria-expanded": "false", class: "number" });
  const open = (/** @type {boolean} */ yes) => {
    box.hidden = !yes;
    toggle.setAttribute("aria-expanded", String(yes));
  };
  const around = el("span", { class: "around" }, toggle, box);
  around.addEventListener("focusout", (e) => {
    if (!(e.relatedTarget instanceof Node && around.contains(e.relatedTarget))) open(false);
  });
  around.addEventListener("keydown", (e) => e.key === "Escape" && [open(false), toggle.focus()]);
  return around;
}

/** @param {string} name @param {Part} part */
function row(name, part) {
  const bar = el("i");
  bar.style.transform = `scaleX(${part.worth})`;
  const loss = part.loss >= 0.5 ? `−${Math.round(part.loss)}` : "";
  return el(
    "div",
    { class: "part", title: MEANS[name] ?? "" },
    el("dt", {}, readable(name), el("span", { class: "sentence" }, MEANS[name] ?? "")),
    el("dd", { class: "number" }, loss),
    el("dd", { class: "worth" }, el("span", { class: "bar" }, bar)),
  );
}
