/** The steps that led to what is seen, each made of what the one before it made; a step made otherwise is a branch. */

import { button, el, fill, there } from "../core/dom.js";
import { exemplarOf, store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { title } from "../core/words.js";

/** @typedef {import("../core/types.js").Job} Job */

/** @type {string[]} jobs from the first step on, as far as they were gone; those after what is looked at as well */
let line = [];
/** @type {{of: string, jobs: Job[]} | null} what came after a step that was made otherwise */
let later = null;

/** The jobs that led to what is seen, the first one first, and the example that they began with.
 * @returns {{first: import("../core/types.js").Exemplar | null, jobs: Job[]}} */
function path() {
  const jobs = [];
  let exemplar = store.exemplar;
  const seen = store.jobs.get(store.chosen ?? "");
  if (seen && seen.verb !== "render" && seen.exemplars[0] === exemplar?.id) jobs.push(seen);
  while (exemplar?.from && jobs.length < 99) {
    const made = store.made.find((job) => job.result === exemplar?.from);
    const before = made && exemplarOf(made);
    if (!made || !before) break;
    jobs.unshift(made);
    exemplar = before;
  }
  return { first: exemplar, jobs };
}

/** @param {string[]} now */
function follow(now) {
  const at = now.findIndex((id, n) => line[n] !== id);
  if (at < 0) return; // what is seen lies on the line
  const rest = line.slice(at + 1).map((id) => store.jobs.get(id) ?? null).filter(there);
  const instead = store.jobs.get(line[at] ?? "")?.exemplars[0] === store.jobs.get(now[at] ?? "")?.exemplars[0];
  if (rest.length && instead && at === now.length - 1) later = { of: now[at] ?? "", jobs: rest };
  line = now;
}

/** Make what came after a step again, each of what is made now. */
async function again() {
  if (!later) return;
  let { of } = later;
  const { jobs } = later;
  later = null;
  for (const { verb, options } of jobs) {
    const result = (await store.ended(of))?.result;
    if (!result) return;
    await store.bring({ result });
    of = (await store.start(verb, [store.exemplar?.id ?? ""], options)).id;
    store.look(of);
  }
}

/** Draw the steps; nothing where there is no more than one.
 * @param {HTMLElement} place */
export function drawSteps(place) {
  const { first, jobs } = path();
  follow(jobs.map((job) => job.id));
  const all = line.map((id) => store.jobs.get(id) ?? null).filter(there);
  place.hidden = all.length < 2 && !later;
  if (place.hidden || !first) return fill(place);
  const row = (/** @type {string} */ says, /** @type {boolean} */ here, /** @type {() => void} */ act) =>
    el("li", {}, button(says, act, { class: "step one-line", "aria-current": here ? "step" : null, title: says }));
  const go = (/** @type {Job} */ job) => {
    const made = exemplarOf(job);
    if (made) store.choose(made);
    store.look(job.id);
  };
  fill(
    place,
    el("h3", {}, "Steps"),
    el("ol", { class: "steps" }, row(first.name, jobs.length === 0, () => store.choose(first)), all.map((job) => row(title(job), job.id === jobs.at(-1)?.id, () => go(job)))),
    later?.of === jobs.at(-1)?.id && later && button(`Make the ${later.jobs.length === 1 ? "step" : `${later.jobs.length} steps`} after it again`, () => void tried(again), { class: "framed" }),
  );
}
