/** Gallery: everything that was made, large enough to judge; and what can be done with each. */

import { button, el, fill } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { growing } from "../core/settings.js";
import { store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { anySeed, busy, facts, state, title, took } from "../core/words.js";
import { carryOn } from "../parts/bring.js";
import { Cell } from "../parts/cell.js";
import { takeAway } from "../parts/taking.js";

/** @typedef {import("../core/types.js").Job} Job */

const STEP = 60;

export class GalleryRoom extends HTMLElement {
  grid = el("ul", { class: "gallery-grid" });
  head = el("div", { class: "gallery-head" });
  more = button("Show more", () => [(this.most += STEP), this.#draw()], { class: "framed" });
  most = STEP;
  /** @type {Map<string, {cell: Cell, element: HTMLElement, seen: string}>} */
  #cards = new Map();
  #gone = new AbortController();

  connectedCallback() {
    this.className = "gallery";
    fill(this, this.head, this.grid, this.more);
    store.on(["jobs", "preview"], () => this.#draw(), this.#gone.signal);
  }

  disconnectedCallback() {
    this.#gone.abort();
  }

  #draw() {
    const all = store.made;
    const shown = all.slice(0, this.most);
    this.more.hidden = all.length <= this.most;
    fill(
      this.head,
      el("h1", {}, "Gallery"),
      el("span", { class: "quiet number" }, all.length ? `${all.length} made` : "Nothing was made yet. What grows is kept here."),
    );
    for (const [id, card] of this.#cards) {
      if (shown.some((job) => job.id === id)) continue;
      card.element.remove();
      this.#cards.delete(id);
    }
    shown.forEach((job, n) => {
      const card = this.#cards.get(job.id) ?? this.#make(job);
      this.#cards.set(job.id, card);
      if (this.grid.children[n] !== card.element) this.grid.insertBefore(card.element, this.grid.children[n] ?? null);
      this.#show(card, job);
    });
  }

  /** @param {Job} job */
  #make(job) {
    const cell = new Cell(job.id, 480, (now) => open(now));
    return { cell, element: el("li", { class: "made" }, cell.element, el("div", { class: "says" })), seen: "" };
  }

  /** @param {{cell: Cell, element: HTMLElement, seen: string}} card @param {Job} job */
  #show(card, job) {
    card.cell.show();
    const seen = `${job.state} ${job.score}`;
    if (card.seen === seen) return;
    card.seen = seen;
    const says = card.element.querySelector(".says");
    if (!says) return;
    const name = store.exemplars.find((e) => e.id === job.exemplars[0])?.name ?? job.label ?? job.verb;
    const score = typeof job.score === "number" ? `score ${Math.round(job.score)}` : "";
    const told = job.state === "done" ? facts(took(job), score) : state(job);
    fill(
      says,
      el("h3", { class: "one-line" }, name),
      el("p", { class: "quiet small one-line" }, title(job)),
      el("p", { class: "quiet small number one-line" }, told),
      el("div", { class: "tools" }, tools(job)),
    );
  }
}

/** Look at a job in the room that it was made in.
 * @param {Job} job */
function open(job) {
  const exemplar = store.exemplars.find((e) => e.id === job.exemplars[0]);
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
    made.push(el("a", { class: "button icon", href: zip, download: `${job.result}.zip`, title: "Download all", "aria-label": "Download all" }, icon("down")));
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
