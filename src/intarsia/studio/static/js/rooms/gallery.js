/** Gallery: everything that was made, large enough to judge; and what can be done with each. */

import { button, el, fill, Living } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { growing } from "../core/settings.js";
import { exemplarOf, store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { anySeed, busy, facts, state, title, took } from "../core/words.js";
import { carryOn } from "../parts/bring.js";
import { arrange, Cell } from "../parts/cell.js";
import { diskUse, heading } from "../parts/names.js";
import { bringing, takeAway } from "../parts/taking.js";

/** @typedef {import("../core/types.js").Job} Job */

const STEP = 60;

export class GalleryRoom extends Living {
  grid = el("ul", { class: "gallery-grid" });
  head = el("div", { class: "gallery-head" });
  more = button("Show more", () => [(this.most += STEP), this.#draw()], { class: "framed" });
  most = STEP;
  disk = diskUse();
  /** @type {Map<string, Cell>} */ #cells = new Map();

  connectedCallback() {
    this.className = "gallery";
    fill(this, this.head, this.grid, this.more);
    store.on(["jobs", "exemplars", "preview"], () => this.#draw(), this.gone.signal);
  }

  #draw() {
    const all = store.made;
    const failed = all.filter((job) => !busy(job) && job.state !== "done").map((job) => job.id);
    this.more.hidden = all.length <= this.most;
    fill(
      this.head,
      el("h1", {}, "Gallery"),
      el("span", { class: "quiet number" }, all.length ? `${all.length} made` : "Nothing was made yet. What grows is kept here."),
      this.disk,
      bringing(),
      failed.length > 0 && button(`Clear ${failed.length} failed`, () => void takeAway("jobs", ...failed), { class: "framed" }),
    );
    arrange(this.grid, this.#cells, all.slice(0, this.most).map((job) => job.id), (id) => {
      const cell = new Cell(id, 480, (job) => open(job));
      cell.place = el("li", { class: "made" }, cell.element, el("div", { class: "says" }));
      return cell;
    });
    for (const job of all.slice(0, this.most)) this.#say(job);
  }

  /** @param {Job} job */
  #say(job) {
    /** @type {HTMLElement | null | undefined} */
    const says = this.#cells.get(job.id)?.place.querySelector(".says");
    const name = exemplarOf(job)?.name ?? job.label ?? job.verb;
    const seen = `${job.state} ${job.score} ${name} ${job.name}`;
    if (!says || says.dataset.seen === seen || says.querySelector("input")) return; // a name that is typed stays
    says.dataset.seen = seen;
    const score = typeof job.score === "number" ? `score ${Math.round(job.score)}` : "";
    const told = job.state === "done" ? facts(took(job), score) : state(job);
    fill(
      says,
      heading("jobs", job, "h3", name),
      el("p", { class: "quiet small one-line" }, title(job)),
      el("p", { class: "quiet small number one-line" }, told),
      el("div", { class: "tools" }, tools(job)),
    );
  }
}

/** Look at a job in the room that it was made in.
 * @param {Job} job */
function open(job) {
  const exemplar = exemplarOf(job);
  if (exemplar) store.choose(exemplar);
  store.look(job.id);
  location.hash = `#grow/${job.id}`;
}

/** @param {Job} job @returns {HTMLElement[]} */
function tools(job) {
  if (busy(job)) return [button("Cancel", () => void tried(() => store.change(job, "cancel")), { icon: icon("close"), bare: true })];
  const made = [];
  const other = () =>
    void tried(() => store.start(job.verb, job.exemplars, { ...job.options, seed: anySeed() }));
  if (job.state === "done") {
    if (job.verb !== "render") made.push(button("Again with another seed", other, { icon: icon("dice"), bare: true }));
    if (job.verb === "grow") made.push(button("Use these settings", () => reuse(job), { icon: icon("undo"), bare: true }));
    const zip = `/api/results/${job.result}/all.zip`;
    made.push(el("a", { class: "button icon", href: zip, download: "", title: "Download all", "aria-label": "Download all" }, icon("down")));
    made.push(button("Continue from this", () => void carryOn(job.result ?? ""), { icon: icon("onward"), bare: true }));
  } else made.push(button("Again", () => void tried(() => store.change(job, "again")), { icon: icon("again"), bare: true }));
  made.push(button("Delete", () => void takeAway("jobs", job.id), { icon: icon("bin"), bare: true }));
  return made;
}

/** @param {Job} job */
function reuse(job) {
  growing.replace(job.options);
  open(job);
}

customElements.define("gallery-room", GalleryRoom);
