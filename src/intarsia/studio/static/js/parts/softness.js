/** How soft the seams of a result are: it is drawn again from its map, and nothing is grown. */

import { el } from "../core/dom.js";
import { exemplarOf, mapOf, store } from "../core/store.js";
import { complain, tried } from "../core/toast.js";

/** px, at the right end of the slider. */
const SOFTEST = 32;

const MOMENT = 200;

/** What was asked for when a result was grown that drawing it again needs, too. */
const SAME = ["alpha", "crop", "scale", "flatten", "magnify", "toroidal", "depth", "layers", "packed", "mixing", "even_tone"];

export class Softness {
  range = el("input", { class: "range", type: "range", min: "0", step: "1", oninput: () => this.#moved() });
  told = el("span", { class: "number", "aria-hidden": "true" });
  element = el(
    "label",
    { class: "softness small", title: "How far pieces run into each other; with 0 they are exact copies. Nothing is grown anew", hidden: true },
    el("span", { class: "quiet" }, "Soften seams"), this.range, this.told,
  );
  /** @type {{job: import("../core/types.js").Job, map: string} | null} what is drawn again */
  #subject = null;
  #soon = 0;
  #turn = 0;

  /** A result is on the stage, or none is.
   * @param {import("../core/types.js").Job | null} job @param {import("../core/types.js").Result} [result] */
  show(job, result) {
    const map = result && mapOf(result);
    const able = job && map && exemplarOf(job) && !job.options.window;
    this.element.hidden = !able;
    if (!able || this.#subject?.map !== map) this.#halt();
    this.#subject = able ? { job, map } : null;
    if (!able) return;
    const now = result.told?.blend?.feather ?? 0;
    this.range.max = String(Math.max(SOFTEST, now));
    if (!this.#soon) this.range.value = String(now);
    this.#say();
  }

  #halt() {
    clearTimeout(this.#soon);
    this.#soon = 0;
    this.#turn++;
  }

  #moved() {
    this.#halt();
    this.#soon = window.setTimeout(() => void tried(() => this.#draw()), MOMENT);
    this.#say();
  }

  #say() {
    const says = `${this.range.value} px`;
    this.told.textContent = this.#soon ? `${says} …` : says;
    this.range.setAttribute("aria-valuetext", says);
  }

  /** Draw what is on the stage as soft as was asked for, and show it; what was drawn so before is shown again. */
  async #draw() {
    const subject = this.#subject;
    const turn = ++this.#turn;
    if (!subject) return;
    const { job, map } = subject;
    const seen = store.chosen;
    const feather = Number(this.range.value);
    const exemplars = job.verb === "render" ? job.exemplars : [...job.exemplars, ...(job.options.from ?? [])];
    const known = store.made.find((one) => one.state === "done" && one.verb === "render" && one.options.map === map && one.options.feather === feather);
    const asked = known ?? (await store.start("render", exemplars, { ...kept(job.options), map, feather }));
    const ended = await store.ended(asked.id);
    if (turn !== this.#turn) return;
    this.#soon = 0;
    this.#say();
    if (ended?.state === "done" && store.chosen === seen) store.look(ended.id);
    else if (ended?.error) complain(ended.error);
  }
}

/** @param {import("../core/types.js").Options} options */
function kept(options) {
  return Object.fromEntries(Object.entries(options).filter(([name]) => SAME.includes(name)));
}
