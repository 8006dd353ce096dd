/** How long something will take: as the last jobs of its kind took here, or else as on an ordinary computer. */

import { store } from "../core/store.js";
import { about } from "../core/words.js";
import { wantedSize } from "./awaited.js";

/** @typedef {import("../core/types.js").Job} Job */

/** Seconds for a megapixel on two cores, where no job of this kind has been done here yet. */
const USUAL = /** @type {Record<string, number>} */ ({
  auto: 10, graphcut: 12, "efros-leung": 500, "wei-levoy": 70, ashikhmin: 30, "segment-based": 30, "patch-sampling": 10,
});
const OTHERS = 5;
const START = 0.5; // s that every job takes
const LASTS = 5;

/** @param {Job} job */
function kind(job) {
  return `${job.verb} ${job.options.method ?? "auto"}`;
}

/** @param {Job} job */
function area(job) {
  const [width, height] = wantedSize(job);
  return Math.max(1e-3, (width * height) / 1e6);
}

/** Seconds that jobs like these will take, one after the other.
 * @param {Pick<Job, "verb" | "exemplars" | "options">[]} asked */
export function estimate(asked) {
  let seconds = 0;
  for (const each of asked) {
    const job = /** @type {Job} */ (each);
    const done = store.made.filter((other) => other.state === "done" && other.began && other.ended && kind(other) === kind(job));
    const rates = done.slice(0, LASTS).map((other) => Math.max(0, (other.ended ?? 0) - (other.began ?? 0) - START) / area(other));
    rates.sort((a, b) => a - b);
    seconds += START + (rates[rates.length >> 1] ?? USUAL[job.options.method ?? "auto"] ?? OTHERS) * area(job);
  }
  return seconds;
}

/** What is left of a job that is running, in words; nothing before it is known.
 * @param {Job} job */
export function left(job) {
  if (job.state !== "running" || !job.began) return "";
  const spent = Date.now() / 1000 - job.began;
  const fraction = job.fraction ?? 0;
  const seconds = fraction > 0.1 ? (spent * (1 - fraction)) / fraction : estimate([job]) - spent;
  return seconds > 1 ? `${about(seconds)} left` : "";
}
