/** What is looked at: the exemplar, a picture as it grows, or a result; on the stage, with what can be done with it. */

import { el, fill } from "../core/dom.js";
import { planeOf, store } from "../core/store.js";
import { complain } from "../core/toast.js";
import { size, title, took } from "../core/words.js";
import { Stage } from "../stage/stage.js";
import { busy, showProgress } from "./progress.js";
import { resultActions } from "./result-actions.js";
import { viewButtons } from "./view-buttons.js";

/** @typedef {import("../core/types.js").Job} Job */
/** @typedef {import("../core/types.js").Result} Result */

export class ResultView extends HTMLElement {
  stage = new Stage();
  head = el("div", { class: "head" });
  progress = el("div", { class: "progress", hidden: true });
  bar = el("div", { class: "stage-bar" });
  told = el("span", { class: "told small number", "aria-live": "off" });
  /** @type {Job | null} */
  job = null;
  /** @type {Result | null} */
  result = null;
  #gone = new AbortController();
  #turn = 0;
  #shown = "";

  connectedCallback() {
    this.className = "result-view";
    fill(this.bar, viewButtons(this.stage), this.told, this.progress);
    fill(this, this.head, this.stage, this.bar);
    store.on(["chosen", "jobs", "exemplar", "preview"], () => void this.#update(), this.#gone.signal);
  }

  disconnectedCallback() {
    this.#gone.abort();
  }

  async #update() {
    const turn = ++this.#turn;
    this.job = store.jobs.get(store.chosen ?? "") ?? null;
    showProgress(this.progress, this.job);
    try {
      await this.#picture(() => turn === this.#turn);
    } catch (error) {
      if (turn === this.#turn) complain(error);
    }
  }

  /**
   * Show what belongs to the chosen job, unless something else was chosen meanwhile.
   * @param {() => boolean} still
   */
  async #picture(still) {
    const { job } = this;
    const exemplar = store.exemplar;
    if (job?.state === "done" && job.result) {
      if (this.#shown === job.result) return;
      const result = await store.result(job.result);
      const picture = await store.shown(result);
      if (!still()) return;
      this.result = result;
      this.#show(job.result, picture, title(job));
      this.#headline(title(job), `${size(...result.size)}   ${took(job)}`, resultActions(result, planeOf(result)));
      return;
    }
    this.result = null;
    const number = job && busy(job) ? store.previews.get(job.id) : undefined;
    if (job && number !== undefined) {
      const preview = await store.picture(`/api/jobs/${job.id}/preview.png?number=${number}`);
      if (still()) this.#show(`${job.id} ${number}`, preview, "Growing");
    } else if (exemplar && !(job && this.#shown.startsWith(job.id))) {
      if (this.#shown === exemplar.id) return;
      const picture = await store.exemplarPicture(exemplar);
      if (still()) this.#show(exemplar.id, picture, `Exemplar ${exemplar.name}`);
    }
    if (still()) this.#headline(job ? title(job) : "Exemplar", job || !exemplar ? "" : size(exemplar.width, exemplar.height), []);
  }

  /**
   * @param {string} what
   * @param {ImageBitmap} picture
   * @param {string} name
   */
  #show(what, picture, name) {
    this.#shown = what;
    this.stage.show(picture, name);
    this.dispatchEvent(new Event("shown"));
  }

  /**
   * @param {string} name
   * @param {string} facts
   * @param {HTMLElement[]} actions
   */
  #headline(name, facts, actions) {
    fill(
      this.head,
      el("h2", { class: "one-line" }, name),
      el("span", { class: "quiet small number one-line facts" }, facts),
      el("span", { class: "actions" }, actions),
    );
  }
}

customElements.define("result-view", ResultView);
