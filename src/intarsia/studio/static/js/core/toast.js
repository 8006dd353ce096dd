/** One quiet line at the bottom: what was refused stays until it is put away, what was done goes by itself. */

import { button, el } from "./dom.js";
import { icon } from "./icons.js";
import { inPlain } from "./words.js";

export const OFFERED = 10_000; // ms

/** @type {HTMLElement | null} */ let shown = null;

/** @param {string} line @param {boolean} bad @param {HTMLElement} [more] what can be done about it */
function show(line, bad, more) {
  shown?.remove();
  const put = button("Dismiss", () => line_.remove(), { icon: icon("close"), bare: true });
  const line_ = el("div", { class: bad ? "toast bad" : "toast", role: bad ? "alert" : "status" }, el("span", {}, line), more, put);
  document.body.append(line_);
  shown = line_;
  return line_;
}

/** Say what was done, and offer to undo it for ten seconds.
 * @param {string} line @param {() => void} act */
export function offer(line, act) {
  const line_ = show(line, false, button("Undo", () => [line_.remove(), act()], { class: "framed" }));
  line_.dataset.at = String(Date.now());
  setTimeout(() => line_.remove(), OFFERED);
}

/** Undo what was offered after a time, if it still stands.
 * @param {number} since @returns {boolean} */
export function takeOffer(since) {
  const stands = shown?.isConnected && Number(shown.dataset.at) >= since;
  if (stands) shown?.querySelector("button")?.click();
  return Boolean(stands);
}

/** @param {string} line @param {boolean} [stays] until it is put away, or something else is said
 * @returns {HTMLElement} */
export function say(line, stays = false) {
  const line_ = show(line, false);
  if (!stays) setTimeout(() => line_.remove(), 4000);
  return line_;
}

/** @param {unknown} error */
export function complain(error) {
  show(inPlain(error instanceof Error ? error.message : String(error)), true);
}

/** Do something that may be refused, and say so.
 * @template T
 * @param {() => Promise<T>} act @returns {Promise<T | undefined>} */
export async function tried(act) {
  try {
    return await act();
  } catch (error) {
    complain(error);
    return undefined;
  }
}

/** Copy text, and say so.
 * @param {string} text @param {string} line */
export async function copied(text, line) {
  await tried(async () => {
    await navigator.clipboard.writeText(text);
    say(line);
  });
}
