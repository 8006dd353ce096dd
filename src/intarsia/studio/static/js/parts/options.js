/** Options that are not of one method, in groups, as the schema of a verb has them. */

import { there } from "../core/dom.js";
import { store } from "../core/store.js";
import { field } from "./field.js";
import { group } from "./methods.js";

/** @type {[string, string[]][]} */
const GROUPS = [
  ["Seams and light", ["feather", "mixing", "even_tone", "repair"]],
  ["Example", ["flatten", "scale", "toroidal", "alpha", "avoid"]],
  ["Result", ["depth", "magnify", "trials"]],
];

/** @param {string} verb @param {import("../core/settings.js").Settings} settings @returns {HTMLElement[]} */
export function optionGroups(verb, settings) {
  const options = store.schema?.verbs[verb] ?? [];
  const made = GROUPS.map(([name, names]) => {
    const fields = names.flatMap((n) => options.filter((o) => o.name === n)).map((o) => field(o, settings));
    return fields.length ? group(name, fields, false) : null;
  });
  return made.filter(there);
}

/** What a verb lets choose for an option.
 * @param {string} verb @param {string} name @returns {string[]} */
export function choicesOf(verb, name) {
  return store.schema?.verbs[verb]?.find((o) => o.name === name)?.choices ?? [];
}

