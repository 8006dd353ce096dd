/** What was found in an exemplar, in words: what can be drawn over it, and why it would be grown so. */

import { button, el } from "../core/dom.js";
import { growing } from "../core/settings.js";
import { called, inPlain } from "../core/words.js";
import { take } from "./methods.js";

/** @type {Record<string, string>} */
const NAMES = { lattice: "Repeating grid", courses: "Rows of stones", striking: "What stands out", segments: "Parts" };

/** What is known of a kind, in a few words; null where there is none.
 * @param {import("../core/types.js").Found} found @param {string} kind @returns {string | null} */
function fact(found, kind) {
  const { lattice, segments, courses } = found;
  const px = (/** @type {number[]} */ sides) => `${sides.map((side) => Math.round(side)).join(" × ")} px`;
  if (kind === "lattice") return lattice ? px(lattice.periods) : null;
  if (kind === "segments") return segments ? String(segments.count) : null;
  if (kind === "courses") return courses ? String(Array.isArray(courses) ? courses.length : (courses.count ?? "found")) : null;
  return "";
}

/** A switch for each thing that can be drawn.
 * @param {import("../core/types.js").Found} found @param {(kind: string, yes: boolean) => void} turn
 * @returns {HTMLElement} */
export function overlays(found, turn) {
  const rows = (found.overlays ?? []).map((/** @type {string} */ kind) => {
    const told = fact(found, kind);
    const box = el("input", {
      class: "switch", type: "checkbox", role: "switch", id: `overlay-${kind}`, disabled: told === null,
      onchange: () => turn(kind, box.checked),
    });
    return el(
      "div",
      { class: "overlay" },
      el("label", { for: `overlay-${kind}` }, NAMES[kind] ?? kind),
      el("span", { class: "quiet number" }, told ?? "none"),
      box,
    );
  });
  return el("div", { class: "overlays", role: "group", "aria-label": "Drawn over the example" }, rows);
}

/** What auto would take, and why; and why there is a lattice, or none.
 * @param {import("../core/types.js").Found} found @returns {HTMLElement} */
export function reasons(found) {
  const { suggested, lattice, reason, light } = found;
  const lines = (/** @type {string[]} */ told) => el("ul", { class: "reasons" }, told.map((line) => el("li", {}, inPlain(line))));
  const grow = () => {
    if (suggested) take(growing, suggested.method);
    location.hash = "#grow";
  };
  return el(
    "div",
    { class: "group why" },
    suggested && el("h3", {}, `Automatic takes: ${called(suggested.method)}`),
    suggested && lines(suggested.why ?? []),
    suggested && button(`Grow with ${called(suggested.method)}`, grow, { class: "framed" }),
    el("h3", {}, "Repeating grid"),
    lines([!lattice ? "No grid is seen that returns in even steps." : lattice.periods.length > 1 ? `It repeats every ${fact(found, "lattice")}.` : `Its rows are ${fact(found, "lattice")} apart.`]),
    el("details", { class: "fold" }, el("summary", {}, "How it was measured"), lines(lattice?.reasons ?? [reason])),
    light && el("h3", {}, "Light"),
    light && lines([light.strong ? "It is lit unevenly: flatten it first." : "It is lit evenly enough."]),
  );
}
