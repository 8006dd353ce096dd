/** Names and numbers as people read them. */

/** @typedef {import("./types.js").Job} Job */

/**
 * `min_repeat_distance` as "Min repeat distance".
 * @param {string} name
 */
export function readable(name) {
  const words = name.replaceAll(/[_-]/g, " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/**
 * How long a job took, or has taken.
 * @param {Job} job
 */
export function took(job) {
  if (!job.began) return "";
  const seconds = (job.ended ?? Date.now() / 1000) - job.began;
  return seconds < 60 ? `${Math.max(0, seconds).toFixed(1)} s` : `${Math.floor(seconds / 60)} min ${Math.round(seconds % 60)} s`;
}

/**
 * @param {number} width
 * @param {number} height
 */
export function size(width, height) {
  return `${width} × ${height}`;
}

/** @param {number} bytes */
export function weight(bytes) {
  if (bytes < 1e3) return `${bytes} B`;
  return bytes < 1e6 ? `${Math.round(bytes / 1e3)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

/**
 * A few facts in one line.
 * @param {...(string | null | undefined)} told those that are empty are left out
 */
export function facts(...told) {
  return told.filter(Boolean).join(" · ");
}

/**
 * A job in a few words: its method and seed, or how soft it was drawn.
 * @param {Job} job
 */
export function title(job) {
  const { method, seed, feather } = job.options;
  if (job.verb === "render") return feather ? `Seams ${feather} px soft` : feather === 0 ? "Exact copies" : "Drawn again";
  const verbs = /** @type {Record<string, string>} */ ({ grow: "Grown", paint: "Painted", extend: "Extended", heal: "Healed", tile: "Tiled", weave: "Woven" });
  const first = method && method !== "auto" ? method : (verbs[job.verb] ?? readable(job.verb));
  return `${first}, seed ${seed ?? 0}`;
}

/**
 * What a job that is under way makes.
 * @param {Job} job
 */
export function doing(job) {
  const verbs = /** @type {Record<string, string>} */ ({ grow: "Growing", extend: "Extending", heal: "Healing", paint: "Painting", render: "Drawing", tile: "Tiling", weave: "Weaving" });
  return verbs[job.verb] ?? "Working";
}

/**
 * @param {number} seconds that something will take, not known well
 */
export function about(seconds) {
  if (seconds <= 0) return "a little longer";
  return seconds < 60 ? `about ${Math.ceil(seconds / 5) * 5} s` : `about ${Math.round(seconds / 60)} min`;
}

/**
 * What a job is at, in a few words.
 * @param {Job} job
 */
export function state(job) {
  const later = /** @type {Record<string, string>} */ ({ repair: "Repairing", render: "Drawing" });
  if (job.state === "running") return later[job.stage ?? ""] ?? doing(job);
  if (job.state === "queued" && job.stage) return `Waiting: ${job.stage}`;
  return { queued: "Waiting", done: "Done", failed: "Failed", cancelled: "Cancelled", interrupted: "Interrupted" }[job.state];
}

/** A seed that nobody thought of. */
export function anySeed() {
  return Math.floor(Math.random() * 1_000_000);
}
