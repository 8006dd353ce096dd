/** Names and numbers as people read them. */

/** @typedef {import("./types.js").Job} Job */

/** `min_repeat_distance` as "Min repeat distance".
 * @param {string} name */
export function readable(name) {
  const words = name.replaceAll(/[_-]/g, " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** @type {Record<string, string>} options whose own names say little */
const TITLES = {
  feather: "Soften seams", mixing: "Mix seams", even_tone: "Even out tone", repair: "Mend seams", toroidal: "Tiles already", alpha: "Opacity",
  avoid: "Colour to avoid", flatten: "Flatten light", depth: "Bits", magnify: "Grow small", trials: "Best of", scale: "Reduce", weight: "Follow what is painted", wrap: "Tiles",
};

/** What an option is called.
 * @param {string} name */
export function titleOf(name) {
  return TITLES[name] ?? readable(name);
}

/** @type {[RegExp, string][]} words of commands and papers, and those of the page */
const PLAIN = [
  [/Invalid value for '--?([\w-]+)[^']*': /g, "$1: "], [/in the range (\S+?)<=x<=(\S+\d)/g, "from $1 to $2"],
  [/\b([Ee])xemplar/g, "$1xample"], [/\b(l)attices?\b/g, "grid"], [/\bplane(s?)\b/g, "map$1"], [/\bisometries\b/g, "turned and mirrored pieces"],
  [/\bisometry\b/g, "turned or mirrored piece"], [/\bperiods\b/g, "tiles"], [/\bperiod\b/g, "tile"],
];

/** What the server tells, in the words of the page.
 * @param {string} text */
export function inPlain(text) {
  const slugs = Object.entries(METHODS).filter(([slug]) => /-|graphcut|ashikhmin/.test(slug));
  const told = slugs.reduce((now, [slug, [name]]) => now.replaceAll(slug, name), text);
  return PLAIN.reduce((now, [from, to]) => now.replace(from, to), told);
}

/** How long a job took, or has taken.
 * @param {Job} job */
export function took(job) {
  if (!job.began) return "";
  const seconds = (job.ended ?? Date.now() / 1000) - job.began;
  return seconds < 60 ? `${Math.max(0, seconds).toFixed(1)} s` : `${Math.floor(seconds / 60)} min ${Math.round(seconds % 60)} s`;
}

/** @param {number} width @param {number} height */
export function size(width, height) {
  return `${width} × ${height}`;
}

/** @param {number} bytes */
export function weight(bytes) {
  if (bytes < 1e3) return `${bytes} B`;
  if (bytes < 1e6) return `${Math.round(bytes / 1e3)} kB`;
  return bytes < 1e9 ? `${(bytes / 1e6).toFixed(1)} MB` : `${(bytes / 1e9).toFixed(1)} GB`;
}

/** A few facts in one line.
 * @param {...(string | null | undefined)} told those that are empty are left out */
export function facts(...told) {
  return told.filter(Boolean).join(" · ");
}

/** @type {Record<string, [string, string, ...string[]]>} methods as one who knows no paper would call them, what they are for, and tags */
const METHODS = {
  auto: ["Automatic", "picks what suits this picture"],
  graphcut: ["Free shapes", "best for most pictures; pieces are cut around what is seen"],
  "image-quilting": ["Square pieces", "also for what is painted or goes on", "quick"],
  "patch-sampling": ["Soft squares", "squares whose borders fade into each other", "quick"],
  "segment-based": ["Pieces by parts", "as large as the parts of the picture that lie there"],
  "near-regular": ["Bricks and tiles", "for walls, floors and weaves", "keeps rows", "quick"],
  "gap-filling": ["Grid with gaps", "blocks of a grid, what lies between is filled", "keeps rows"],
  "best-tile": ["One tile", "the best tile of a pattern, again and again", "keeps rows", "quick"],
  "random-tiling": ["Random squares", "without any matching, to compare with", "quick"],
  repeat: ["Repeat", "the whole picture, again and again", "endless", "quick"],
  "parallel-controllable": ["Endless", "pixel by pixel, for sand rather than stones", "endless", "quick"],
  "raster-quilting": ["Squares by rows", "quilting as it was first published", "quick"],
  "efros-leung": ["Pixel by pixel", "fine grain", "takes minutes"],
  "wei-levoy": ["Best pixels", "smooth textures", "slow"],
  ashikhmin: ["Neighbours go on", "leaves, flowers, pebbles", "slow"],
  "correction-2008": ["Endless, of 2008", "an older form of endless", "endless"],
};

/** @param {string} method */
export function plain(method) {
  return METHODS[method];
}

/** @param {string} method */
export function called(method) {
  return METHODS[method]?.[0] ?? method;
}

/** A score in words: how much is wrong, and what mostly, where that is known.
 * @param {number} total @param {string} [flaw] */
export function judged(total, flaw = "flaws") {
  return total >= 90 ? "Clean" : `${total >= 65 ? "Some" : total >= 40 ? "Strong" : "Very strong"} ${flaw}`;
}

/** A job in a few words: its method and seed, or how soft it was drawn.
 * @param {Job} job */
export function title(job) {
  const { method, seed, feather } = job.options;
  if (job.verb === "render") return feather ? `Seams ${feather} px soft` : feather === 0 ? "Exact copies" : "Drawn again";
  const verbs = /** @type {Record<string, string>} */ ({ grow: "Grown", paint: "Painted", extend: "Extended", heal: "Healed", tile: "Tiled", weave: "Woven" });
  const first = method && method !== "auto" && job.verb === "grow" ? called(method) : (verbs[job.verb] ?? readable(job.verb));
  return `${first}, seed ${seed ?? 0}`;
}

/** What a job that is under way makes.
 * @param {Job} job */
export function doing(job) {
  const verbs = /** @type {Record<string, string>} */ ({ grow: "Growing", extend: "Extending", heal: "Healing", paint: "Painting", render: "Drawing", tile: "Tiling", weave: "Weaving" });
  return verbs[job.verb] ?? "Working";
}

/** @param {number} seconds that something will take, not known well */
export function about(seconds) {
  if (seconds <= 0) return "a little longer";
  return seconds < 60 ? `about ${Math.ceil(seconds / 5) * 5} s` : `about ${Math.round(seconds / 60)} min`;
}

/** @param {Job | null | undefined} job */
export function busy(job) {
  return job?.state === "running" || job?.state === "queued";
}

/** What a job is at, in a few words.
 * @param {Job} job */
export function state(job) {
  const stages = /** @type {Record<string, string>} */ ({ look: "Looking at the example", repair: "Repairing", render: "Drawing" });
  if (job.state === "running" || (job.state === "queued" && job.stage)) return stages[job.stage ?? (job.verb === "render" ? "" : "look")] ?? doing(job);
  return { queued: "Waiting", done: "Done", failed: "Failed", cancelled: "Cancelled", interrupted: "Interrupted" }[job.state];
}

/** A seed that nobody thought of. */
export function anySeed() {
  return Math.floor(Math.random() * 1_000_000);
}
