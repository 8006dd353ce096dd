/** One quiet line at the bottom: what was refused stays until it is put away, what was done goes by itself. */

import { button, el } from "./dom.js";
import { icon } from "./icons.js";

/** @type {HTMLElement | null} */
let shown = null;

/**
 * @param {string} line
 * @param {boolean} bad
 */
function show(line, bad) {
  shown?.remove();
  const put = button("Dismiss", () => line_.remove(), { icon: icon("close"), bare: true });
  const line_ = el("div", { class: bad ? "toast bad" : "toast", role: bad ? "alert" : "status" }, el("span", {}, line), put);
  document.body.append(line_);
  shown = line_;
  if (!bad) setTimeout(() => line_.remove(), 4000);
}

/** @param {string} line */
export function say(line) {
  show(line, false);
}

/** @param {unknown} error */
export function complain(error) {
  show(error instanceof Error ? error.message : String(error), true);
}

/**
 * Do something that may be refused, and say so.
 * @template T
 * @param {() => Promise<T>} act
 * @returns {Promise<T | undefined>}
 */
export async function tried(act) {
  try {
    return await act();
  } catch (error) {
    complain(error);
    return undefined;
  }
}

/**
 * Copy text, and say so.
 * @param {string} text
 * @param {string} what
 */
export async function copied(text, what) {
  await tried(async () => {
    await navigator.clipboard.writeText(text);
    say(`${what} copied`);
  });
}
