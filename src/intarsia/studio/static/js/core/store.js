/** What the page knows: exemplars, jobs, results, and which of them are looked at. Who shows it listens for its changes. */

import { get, picture, post, remove, lookOf } from "./api.js";
import { kept } from "./kept.js";
import { busy } from "./words.js";

/** @typedef {import("./types.js").Exemplar} Exemplar */
/** @typedef {import("./types.js").Job} Job */
/** @typedef {import("./types.js").Result} Result */
/** @typedef {"exemplars" | "exemplar" | "jobs" | "chosen" | "source" | "warm" | "here" | "preview"} Topic */

class Store extends EventTarget {
  /** @type {import("./types.js").Schema | null} */ schema = null;
  /** @type {Exemplar[]} newest first */
  exemplars = [];
  /** @type {Exemplar | null} the one that is worked with */
  exemplar = null;
  /** @type {Map<string, Job>} */ jobs = new Map();
  /** @type {string | null} the job that is looked at */
  chosen = null;
  /** Whether the contact sheet is looked at. */
  spread = false;
  /** @type {{x: number, y: number} | null} the exemplar's pixel that the pointer's came from */
  source = null;
  /** @type {{done: number, total: number}} */ warm = { done: 0, total: 0 };
  here = true;
  /** Whether all that the server has was told once. */
  loaded = false;
  #arrived = () => {};
  /** Comes when all that the server has was told once: no room can be furnished before. */
  ready = /** @type {Promise<void>} */ (new Promise((resolve) => (this.#arrived = resolve)));
  /** @type {Map<string, number>} the number of a job's last preview */
  previews = new Map();
  /** @type {Map<string, Promise<Result>>} */ #results = new Map();
  /** @type {Map<string, Promise<ImageBitmap>>} the last few pictures, so that going to and fro is quick */
  #pictures = new Map();
  #soon = new Set();
  /** @type {Set<string>} jobs and exemplars that were taken away, whatever an answer that was on its way still says of them */
  #gone = new Set();

  /** Tell that something changed, once for many changes of a moment.
   * @param {Topic} topic */
  tell(topic) {
    if (this.#soon.has(topic)) return;
    this.#soon.add(topic);
    queueMicrotask(() => {
      this.#soon.delete(topic);
      this.dispatchEvent(new Event(topic));
    });
  }

  /** Call `act` now, and again whenever one of the topics changes, until the signal says stop.
   * @param {Topic[]} topics @param {() => void} act @param {AbortSignal} [signal] */
  on(topics, act, signal) {
    for (const topic of topics) this.addEventListener(topic, act, { signal });
    act();
  }

  /** Ask for all that the server has. */
  async load() {
    const had = this.exemplars;
    const [schema, opened] = await Promise.all([get("/api/schema"), get("/api/exemplars")]);
    const exemplars = this.#there(/** @type {Exemplar[]} */ (opened));
    const brought = this.exemplars.filter((e) => !had.includes(e) && exemplars.every((x) => x.id !== e.id));
    [this.schema, this.exemplars] = [schema, [...brought, ...exemplars].sort(newest)];
    const before = new Map(this.jobs);
    const told = this.#there(/** @type {Job[]} */ (await get("/api/jobs")));
    const newer = [...this.jobs].filter(([id, job]) => before.get(id) !== job); // heard while the answer was on its way
    this.jobs = new Map([...told.map((job) => /** @type {[string, Job]} */ ([job.id, job])), ...newer]);
    this.exemplar = this.exemplars.find((e) => e.id === kept.of().exemplar) ?? null;
    this.loaded = true;
    this.#arrived();
    for (const topic of /** @type {Topic[]} */ (["exemplars", "exemplar", "jobs"])) this.tell(topic);
  }

  /** @template {{id: string}} T
   * @param {T[]} told by the server @returns {T[]} without what was taken away since it was asked */
  #there(told) {
    return told.filter((each) => !this.#gone.has(each.id));
  }

  /** Work with another exemplar; what is looked at belongs to it.
   * @param {Exemplar | null} exemplar */
  choose(exemplar) {
    if (exemplar) this.opened(exemplar);
    this.exemplar = exemplar;
    if (exemplar) kept.set({ exemplar: exemplar.id });
    this.look(null);
    this.tell("exemplar");
  }

  /** @param {Exemplar} exemplar that is there, here or in another page */
  opened(exemplar) {
    this.#gone.delete(exemplar.id);
    this.exemplars = [exemplar, ...this.exemplars.filter((each) => each.id !== exemplar.id)].sort(newest);
    if (this.exemplar?.id === exemplar.id && this.exemplar.name !== exemplar.name) {
      this.exemplar = exemplar;
      this.tell("exemplar");
    }
    this.tell("exemplars");
  }

  /** A new exemplar: files, a built-in sample, or a result.
   * @param {FormData | {sample: string} | {result: string}} from
   * @returns {Promise<Exemplar & {opened?: number, refused?: string[]}>} with how many files made, and which lines were said */
  async bring(from) {
    const brought = await post("/api/exemplars", from);
    await this.ready;
    this.choose(brought);
    return brought;
  }

  /** @param {"jobs" | "exemplars"} kind @param {string} id @param {string} name */
  async rename(kind, id, name) {
    const row = await post(`/api/${kind}/${id}/name`, { name });
    if (kind === "jobs") this.note(row);
    else this.opened(row);
    return row;
  }

  /** @param {Job} job */
  note(job) {
    this.#gone.delete(job.id);
    this.jobs.set(job.id, job);
    this.tell("jobs");
  }

  /** There is a new preview of a job.
   * @param {string} id @param {number} number */
  seen(id, number) {
    this.previews.set(id, number);
    this.tell("preview");
  }

  /** Ask for a job.
   * @param {string} verb @param {string[]} exemplars @param {import("./types.js").Options} options
   * @returns {Promise<Job>} */
  async start(verb, exemplars, options) {
    const job = await post("/api/jobs", { verb, exemplars, options });
    if (!this.jobs.has(job.id)) this.note(job);
    return job;
  }

  /** @param {Job} job @param {"cancel" | "again"} what @returns {Promise<Job>} */
  async change(job, what) {
    const now = await post(`/api/jobs/${job.id}/${what}`);
    this.note(now);
    return now;
  }

  /** A job once it has ended; undefined where it was taken away.
   * @param {string} id @returns {Promise<Job | undefined>} */
  ended(id) {
    return new Promise((done) => {
      const heard = new AbortController();
      this.on(["jobs"], () => busy(this.jobs.get(id)) || [heard.abort(), done(this.jobs.get(id))], heard.signal);
    });
  }

  /** Take a job and what it made away, or an exemplar; for a while it can be brought back.
   * @param {"jobs" | "exemplars"} kind @param {string} id */
  async takeAway(kind, id) {
    await remove(`/api/${kind}/${id}`);
    this.gone(id);
  }

  /** @param {"jobs" | "exemplars"} kind @param {string} id */
  async bringBack(kind, id) {
    const back = await post(`/api/${kind}/${id}/back`);
    if (kind === "jobs") this.note(back);
    else this.opened(back);
  }

  /** @param {string} id of a job or an exemplar that is there no more */
  gone(id) {
    this.#gone.add(id);
    this.jobs.delete(id);
    this.exemplars = this.exemplars.filter((each) => each.id !== id);
    if (this.chosen === id) this.chosen = null;
    if (this.exemplar?.id === id) this.exemplar = null;
    for (const topic of /** @type {Topic[]} */ (["jobs", "chosen", "exemplars", "exemplar"])) this.tell(topic);
  }

  /** @param {string | null} id of the job to look at */
  look(id) {
    this.chosen = id;
    this.spread = false;
    this.tell("chosen");
  }

  /** @returns {string[]} jobs that were asked for together, for the contact sheet */
  get sheet() {
    return kept.of(this.exemplar?.id).sheet ?? [];
  }

  /** @param {string[]} jobs to lay side by side */
  spreadOut(jobs) {
    if (this.exemplar) kept.set({ sheet: jobs }, this.exemplar.id);
    this.spread = jobs.length > 0;
    this.tell("chosen");
  }

  /** Where a small picture of a job that is done lies.
   * @param {Job} job @param {number} side */
  thumb(job, side) {
    const plane = this.exemplars.find((e) => e.id === job.exemplars[0])?.planes[0]?.name ?? "albedo";
    return job.result ? lookOf(job.result, plane, side) : "";
  }

  /** @returns {Job[]} those that grow something, newest first */
  get made() {
    const known = [...this.jobs.values()].filter((job) => job.verb !== "analyze" && job.verb !== "score");
    return known.sort((a, b) => (a.created < b.created ? 1 : a.created > b.created ? -1 : a.id < b.id ? 1 : -1));
  }

  /** @param {string} id
   * @param {number | null} score as far as its job knows it; a result that is judged meanwhile is asked for anew
   * @returns {Promise<Result>} */
  result(id, score) {
    const key = `${id} ${score}`;
    const known = this.#results.get(key);
    if (known) return known;
    const asked = get(`/api/results/${id}`);
    asked.catch(() => this.#results.delete(key));
    this.#results.set(key, asked);
    return asked;
  }

  /** A picture by its address, from memory where it was seen lately.
   * @param {string} path @returns {Promise<ImageBitmap>} */
  picture(path) {
    const known = this.#pictures.get(path) ?? picture(path);
    known.catch(() => this.#pictures.delete(path));
    this.#pictures.delete(path);
    this.#pictures.set(path, known);
    for (const oldest of this.#pictures.keys()) {
      if (this.#pictures.size <= 24) break;
      this.#pictures.delete(oldest);
    }
    return known;
  }
}

/** @param {Exemplar} a @param {Exemplar} b */
function newest(a, b) {
  return b.created - a.created;
}

/** What files of a result hold that is no plane. */
const NO_PLANES = ["map", "report", "sheet", "recipe", "st map", "layers"];

/** The planes that a result has, its base first.
 * @param {Result} result @returns {string[]} */
export function planesOf(result) {
  return result.files.map((file) => file.holds).filter((holds) => !NO_PLANES.includes(holds));
}

/** The result whose map says where each pixel of this one came from: its own, or that which was drawn again; null: none does.
 * @param {Result} result @returns {string | null} */
export function mapOf(result) {
  if (result.files.some((file) => file.holds === "map")) return result.id;
  return result.verb === "render" ? result.options.map : null;
}

export const store = new Store();

/** The exemplar that a job was grown from, where it is still there.
 * @param {Job} job */
export function exemplarOf(job) {
  return store.exemplars.find((each) => each.id === job.exemplars[0]);
}
