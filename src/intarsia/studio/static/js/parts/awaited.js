/** What is seen of a job before there is a preview of its work: a canvas of the size that is wanted, and what is waited for. */

import { exemplarOf, store } from "../core/store.js";
import { about, busy, state } from "../core/words.js";

/** The size of what a job makes, as far as it is known before.
 * @param {import("../core/types.js").Job} job @returns {[number, number]} */
export function wantedSize(job) {
  const { size, width, height, left = 0, right = 0, top = 0, bottom = 0 } = job.options;
  const asked = /^(\d+)(?:x(\d+))?$/.exec(String(size ?? ""));
  if (asked) return [Number(asked[1]), Number(asked[2] ?? asked[1])];
  const exemplar = exemplarOf(job);
  if (!exemplar) return [width ?? 512, height ?? 512];
  const times = job.verb === "grow" || job.verb === "paint" ? 2 : 1;
  return [times * exemplar.width + left + right, times * exemplar.height + top + bottom];
}

/** One grey pixel, to be drawn as large as is wanted. */
export function grey() {
  const canvas = new OffscreenCanvas(1, 1);
  const pen = canvas.getContext("2d");
  if (pen) {
    pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--hover");
    pen.fillRect(0, 0, 1, 1);
  }
  return canvas;
}

/** What a job waits for, or is at, in a line; nothing once previews of the work itself show how far it is.
 * @param {import("../core/types.js").Job | null} job */
export function awaited(job) {
  if (!job || !busy(job) || (job.fraction && store.previews.has(job.id))) return "";
  if (job.state === "running" && job.ready) return `Getting ready, once on this computer: ${about(job.ready - Date.now() / 1000)}`;
  if (job.state === "running" || job.stage) return state(job);
  const before = [...store.jobs.values()].filter((other) => busy(other) && other.created < job.created).length;
  if (before) return `Waiting for ${before === 1 ? "another job" : `${before} other jobs`}`;
  return store.warm.done < store.warm.total ? "Getting ready" : state(job);
}
