/** Several at once: other seeds, or every method, to be laid side by side. */

import { store } from "../core/store.js";

/** @typedef {"1" | "4" | "9" | "methods"} Many */

/** Methods that are there to compare with, and not to choose from. */
const BASELINES = ["repeat", "random-tiling"];

/** What is asked for, one set of options for each picture.
 * @param {Readonly<import("../core/types.js").Options>} options @param {Many} many @param {string[]} allowed methods of the verb
 * @returns {import("../core/types.js").Options[]} */
export function variants(options, many, allowed) {
  const first = Number(options.seed ?? 0);
  if (many !== "methods") {
    return Array.from({ length: Number(many) }, (_, n) => (n || options.seed ? { ...options, seed: first + n } : { ...options }));
  }
  const methods = store.schema?.methods ?? [];
  const parameters = new Set(methods.flatMap((m) => m.parameters.map((p) => p.name)));
  const plain = Object.fromEntries(Object.entries(options).filter(([name]) => !parameters.has(name)));
  const wraps = (options.wrap ?? "none") !== "none";
  return methods
    .filter((m) => allowed.includes(m.slug) && !BASELINES.includes(m.slug) && (!wraps || m.supports.includes("wrap")))
    .map((m) => ({ ...plain, method: m.slug }));
}
