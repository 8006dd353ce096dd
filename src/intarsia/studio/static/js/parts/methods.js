/** Which method grows: each with its sentence, and then its parameters. */

import { el, fill, follow } from "../core/dom.js";
import { store } from "../core/store.js";
import { called, plain } from "../core/words.js";
import { field, isField } from "./field.js";
import { Sketches } from "./sketches.js";

/** @typedef {import("../core/settings.js").Settings} Settings */

const AUTO = { slug: "auto", summary: "picks what suits this picture" };

/** The list closes when something else is pressed, or focused: it lies over the stage.
 * @param {Event} event */
function leave({ target }) {
  for (const box of document.querySelectorAll(".pick[open]")) if (target instanceof Node && !box.contains(target)) box.removeAttribute("open");
}
for (const event of ["pointerdown", "focusin"]) document.addEventListener(event, leave);

/** Take another method; parameters that it does not have are dropped.
 * @param {Settings} settings @param {string} slug */
export function take(settings, slug) {
  const methods = store.schema?.methods ?? [];
  const all = new Set(methods.flatMap((method) => method.parameters.map((p) => p.name)));
  const own = new Set(methods.find((method) => method.slug === slug)?.parameters.map((p) => p.name));
  const kept = Object.entries(settings.options).filter(([name]) => name !== "method" && (!all.has(name) || own.has(name)));
  settings.replace({ ...Object.fromEntries(kept), ...(slug === AUTO.slug ? {} : { method: slug }) });
}

/** @param {Settings} settings @param {string[]} allowed methods that the verb offers @returns {HTMLElement} */
export function methodPicker(settings, allowed) {
  const known = (store.schema?.methods ?? []).filter((method) => allowed.includes(method.slug));
  const offered = [AUTO, ...known];
  const head = el("summary", { class: "pick-head" });
  const list = el("div", { class: "pick-list", role: "radiogroup", "aria-label": "Method" });
  const sketches = settings.name === "grow" ? new Sketches() : null; // they are grown of the whole example
  const box = el("details", { class: "pick" }, head, list);
  for (const method of offered) {
    const radio = el("input", {
      type: "radio", name: "method", value: method.slug, class: "unseen",
      onchange: () => take(settings, method.slug),
      onclick: (/** @type {MouseEvent} */ e) => e.detail > 0 && (box.open = false),
    });
    const tags = (plain(method.slug) ?? []).slice(2).map((tag) => el("span", { class: "tag" }, tag));
    list.append(el("label", { class: "method" }, radio, sketches?.place(method.slug) ?? "", ...says(method, settings), tags.length > 0 && el("span", { class: "tags" }, tags)));
  }
  box.addEventListener("keydown", (e) => e.key === "Escape" && [(box.open = false), head.focus()]);
  box.addEventListener("toggle", () => (box.open ? void sketches?.draw() : sketches?.stop()));
  const show = () => {
    const slug = settings.options.method ?? AUTO.slug;
    const method = offered.find((m) => m.slug === slug) ?? AUTO;
    fill(head, ...says(method, settings));
    for (const radio of list.querySelectorAll("input")) radio.checked = radio.value === slug;
  };
  follow(settings, box, show);
  return el("div", { class: "group" }, el("h3", {}, "Method"), box);
}

/** @param {{slug: string, summary: string, supports?: string[]}} method @param {Settings} settings */
function says(method, settings) {
  const wraps = (settings.options.wrap ?? "none") !== "none";
  const unable = wraps && method.supports && !method.supports.includes("wrap");
  return [
    el("span", { class: "slug" }, called(method.slug)),
    el("span", { class: "sentence" }, unable ? "cannot tile" : plain(method.slug)?.[1] ?? method.summary),
    method.slug !== AUTO.slug && el("span", { class: "quiet small", title: method.summary }, method.slug),
  ];
}

/** The parameters of the method that is named.
 * @param {Settings} settings @returns {HTMLElement} */
export function parameterForm(settings) {
  const place = el("div", { class: "group" });
  let shown = "";
  const show = () => {
    const slug = settings.options.method ?? "auto";
    if (slug === shown) return;
    shown = slug;
    const parameters = store.schema?.methods.find((m) => m.slug === slug)?.parameters.filter(isField) ?? [];
    fill(place, parameters.length > 0 && group(`Options of ${called(slug)}`, parameters.map((p) => field(p, settings)), false));
  };
  follow(settings, place, show);
  return place;
}

/** Fields that can be folded away.
 * @param {string} name @param {HTMLElement[]} fields @param {boolean} open */
export function group(name, fields, open) {
  return el("details", { class: "fold", open }, el("summary", {}, name), el("div", { class: "options" }, fields));
}
