/** How far a job is: a bar, what it is doing, and a way to stop it. */

import { button, el, fill } from "../core/dom.js";
import { store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { busy, facts, inPlain, state, took } from "../core/words.js";
import { left } from "./estimate.js";

/** A bar that is as long as a job is far.
 * @param {import("../core/types.js").Job} job */
export function bar(job) {
  const inside = el("i");
  inside.style.transform = `scaleX(${job.fraction ?? 0})`;
  const percent = Math.round((job.fraction ?? 0) * 100);
  return el("div", { class: "bar", role: "progressbar", "aria-label": "Progress", "aria-valuenow": percent }, inside);
}

/** Show a job that is under way, or why it ended without a result. What is pressed and focused stays while the job goes on.
 * @param {HTMLElement} place @param {import("../core/types.js").Job | null} job */
export function showProgress(place, job) {
  place.hidden = !job || job.state === "done";
  const shown = place.dataset.job;
  place.dataset.job = job && busy(job) ? job.id : "";
  if (!job || place.hidden) return fill(place);
  if (busy(job)) {
    if (shown !== job.id) {
      const cancel = button("Cancel", () => void tried(() => store.change(job, "cancel")), { class: "framed" });
      fill(place, el("div"), el("span", { class: "quiet number" }), cancel);
    }
    const [line, told] = place.children;
    line?.replaceWith(bar(job));
    if (told) told.textContent = facts(state(job), took(job), left(job));
    return;
  }
  const again = button("Again", () => void tried(async () => store.look((await store.change(job, "again")).id)), { class: "framed" });
  const line = el("span", { class: job.error ? "bad" : "quiet", role: "alert" }, inPlain(job.error ?? state(job)));
  fill(place, line, again);
}
