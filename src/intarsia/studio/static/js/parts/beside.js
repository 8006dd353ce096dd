/** An editor, and in its place the result once there is one: what the rooms have in common that draw before they grow. */

import { button, el } from "../core/dom.js";
import { store } from "../core/store.js";
import { carryOn } from "./bring.js";
import { ONWARD } from "./result-actions.js";
import { ResultView } from "./result-view.js";

/** @param {HTMLElement} editor @param {HTMLElement} go the button that asks for a result @param {string} name of the way back
 * @param {import("../core/past.js").Past[]} pasts of what is drawn: what is undone there is looked at @param {AbortSignal} signal
 * @returns {{main: HTMLElement, buttons: HTMLElement, onward: () => Promise<void>}} `onward`: go on from the result, if one is seen */
export function beside(editor, go, name, pasts, signal) {
  const view = new ResultView();
  view.onward = false;
  const made = () => store.jobs.get(store.chosen ?? "")?.result ?? null;
  const onward = async () => {
    const result = made();
    if (result) await carryOn(result);
    else store.look(null);
  };
  const next = button("Continue from this", () => void onward(), { class: "strong big", title: ONWARD });
  const back = button(name, () => store.look(null), { class: "framed big" });
  const turn = () => {
    const seen = store.chosen !== null;
    view.hidden = back.hidden = !seen;
    editor.hidden = seen;
    next.hidden = made() === null;
    go.classList.toggle("strong", next.hidden);
    go.classList.toggle("framed", !next.hidden);
  };
  store.on(["chosen", "jobs"], turn, signal);
  for (const past of pasts) past.addEventListener("turned", () => store.chosen && store.look(null), { signal });
  return { main: el("div", { class: "paint-main" }, editor, view), buttons: el("div", { class: "do" }, go, next, back), onward };
}
