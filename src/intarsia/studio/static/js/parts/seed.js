/** The seed: a number, and a dice for another one. */

import { button, el, follow } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { anySeed } from "../core/words.js";

/** @param {import("../core/settings.js").Settings} settings @returns {HTMLElement} */
export function seedField(settings) {
  const input = el("input", {
    class: "field", id: "seed", type: "number", min: "0", step: "1", placeholder: "0", inputMode: "numeric",
    oninput: () => input.reportValidity() && settings.set("seed", input.value === "" ? null : Number(input.value)),
  });
  follow(settings, input, () => {
    if (document.activeElement !== input) input.value = settings.options.seed ?? "";
  });
  const dice = button("Another seed", () => settings.set("seed", anySeed()), { icon: icon("dice"), bare: true, class: "framed" });
  return el("div", { class: "row" }, el("label", { for: "seed" }, "Seed"), el("span", { class: "joined" }, input, dice));
}
