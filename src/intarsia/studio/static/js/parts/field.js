/** One option as a field, made from what the schema tells of it: kind, range, choices, unit, help. Empty means automatic. */

import { el, follow } from "../core/dom.js";
import { complain } from "../core/toast.js";
import { inPlain, titleOf } from "../core/words.js";

/** @typedef {import("../core/types.js").Option} Option */

const POSES = ["none", "180", "90", "both", "auto"];

/** Kinds that a picture or an exemplar is given for; they have places of their own. */
const PICTURES = ["image", "exemplar", "picture", "file"];

/** @param {Option} option */
export function isField(option) {
  return !PICTURES.includes(option.kind);
}

/** @param {Option} option */
function usual(option) {
  if (option.default === null || option.default === "") return "automatic";
  return Array.isArray(option.default) ? option.default.join("x") : String(option.default);
}

/** @param {Option} option @param {import("../core/settings.js").Settings} settings @returns {HTMLElement} */
export function field(option, settings) {
  const id = `option-${option.name}`;
  const control = input(option, settings, id);
  const show = () => {
    const value = settings.options[option.name];
    if (control instanceof HTMLInputElement && control.type === "checkbox") control.checked = value === true;
    else if (document.activeElement !== control || !settings.options[option.name]) control.value = value ?? "";
  };
  follow(settings, control, show);
  const unit = option.unit ? el("span", { class: "unit" }, option.unit) : null;
  return el(
    "div",
    { class: "option" },
    el("label", { for: id }, titleOf(option.name), unit),
    control,
    el("p", { class: "help", id: `${id}-help` }, sentence(option.help)),
  );
}

/** Whether a field holds what is not allowed: then it is said, and nothing is asked for.
 * @param {Element} place where the fields are */
export function refused(place) {
  const bad = [...place.querySelectorAll("input")].find((input) => !input.validity.valid);
  if (!bad) return false;
  const name = bad.ariaLabel ?? bad.labels?.[0]?.textContent ?? "";
  const range = bad.min && bad.max ? ` from ${bad.min} to ${bad.max}` : bad.min ? ` of at least ${bad.min}` : bad.max && ` of at most ${bad.max}`;
  complain(`${name}: ${bad.value || "this"} is not allowed; give a ${bad.step === "1" ? "whole " : ""}number${range}.`);
  bad.focus();
  return true;
}

/** Two sentences at most, without what is said by the field itself, or of commands.
 * @param {string} help */
function sentence(help) {
  const said = inPlain(help).split(/(?<=\.) (?=[A-Z`])/).filter((each) => !/^(Default|By default)|`|--/.test(each));
  const text = said.slice(0, 2).join(" ").replace(/^./, (first) => first.toUpperCase());
  return /[.!?]$/.test(text) ? text : `${text}.`;
}

/** @param {Option} option @param {import("../core/settings.js").Settings} settings @param {string} id @returns {HTMLInputElement | HTMLSelectElement} */
function input(option, settings, id) {
  const { name, kind, low, high } = option;
  const common = { id, "aria-describedby": `${id}-help` };
  if (kind === "flag") {
    const box = el("input", {
      ...common, class: "switch", type: "checkbox", role: "switch", onchange: () => settings.set(name, box.checked),
    });
    return box;
  }
  const choices = kind === "isometries" ? POSES : kind === "choice" ? option.choices : [];
  if (choices.length) {
    const automatic = el("option", { value: "" }, usual(option));
    const others = choices.filter((c) => c !== option.default).map((c) => el("option", { value: c }, c));
    const list = el("select", { ...common, class: "field", onchange: () => settings.set(name, list.value) }, automatic, others);
    return list;
  }
  const number = kind === "int" || kind === "float";
  const range = number ? { min: low ?? "", max: high ?? "", step: kind === "int" ? "1" : "any" } : {};
  const text = el("input", {
    ...common, ...range, class: "field", type: number ? "number" : "text", placeholder: usual(option), autocomplete: "off",
    oninput: () => {
      if (text.validity.valid) settings.set(name, number && text.value !== "" ? Number(text.value) : text.value.trim());
    },
    onchange: () => text.reportValidity(),
  });
  return text;
}
