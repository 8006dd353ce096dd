/** What is looked at: the exemplar, a picture as it grows, or a result; on the stage, with what can be done with it. */

import { lookOf, LONGEST, Refused, viewOf } from "../core/api.js";
import { button, el, fill } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { exemplarOf, mapOf, planesOf, store } from "../core/store.js";
import { complain, tried } from "../core/toast.js";
import { facts, size, title, took } from "../core/words.js";
import { Stage } from "../stage/stage.js";
import { Compare } from "./compare.js";
import { Looks } from "./looks.js";
import { Origins } from "./origins.js";
import { busy, showProgress } from "./progress.js";
import { resultActions } from "./result-actions.js";
import { scoreButton } from "./score.js";
import { Sheet } from "./sheet.js";
import { Softness } from "./softness.js";
import { Strip } from "./strip.js";
import { viewButtons } from "./view-buttons.js";

/** @typedef {import("../core/types.js").Job} Job */
/** @typedef {import("../core/types.js").Result} Result */

export class ResultView extends HTMLElement {
  stage = new Stage();
  head = el("div", { class: "head" });
  progress = el("div", { class: "progress", hidden: true });
  bar = el("div", { class: "stage-bar" });
  strip = new Strip();
  compare = new Compare(this.stage);
  looks = new Looks(this.stage, () => [(this.#shown = ""), void this.#update()]);
  softness = new Softness();
  origins = new Origins();
  scored = el("span");
  place = el("span", { class: "corner low right number" });
  /** @type {Job | null} */
  job = null;
  /** @type {Result | null} */
  result = null;
  #gone = new AbortController();
  #turn = 0;
  #shown = "";

  connectedCallback() {
    this.className = "result-view";
    this.stage.append(this.looks.legend, this.place);
    fill(this.bar, viewButtons(this.stage), this.looks.element, this.softness.element, this.progress);
    this.stage.addEventListener("hover", (e) => {
      this.place.textContent = e instanceof CustomEvent ? this.origins.tell(e.detail) : "";
    });
    fill(this, this.head, this.stage, this.bar, this.strip, new Sheet());
    this.strip.act = (id) => (this.compare.on ? void this.#against(id) : store.look(id));
    store.on(["chosen", "jobs", "exemplar", "preview"], () => void this.#update(), this.#gone.signal);
  }

  disconnectedCallback() {
    this.#gone.abort();
  }

  async #update() {
    const turn = ++this.#turn;
    this.job = store.jobs.get(store.chosen ?? "") ?? null;
    if (this.compare.on && this.job?.result !== this.result?.id) this.#alone();
    showProgress(this.progress, this.job);
    try {
      await this.#picture(() => turn === this.#turn);
    } catch (error) {
      const over = error instanceof Refused && error.status === 204; // it ended meanwhile: its result comes
      if (turn === this.#turn && !over) complain(error);
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
      const seen = `${job.result} ${job.score}`;
      if (this.#shown === seen) return;
      const result = await store.result(job.result, job.score);
      if (this.result?.id === result.id && this.#shown.startsWith(`${result.id} `)) {
        if (!still()) return;
        this.#shown = seen; // only its score is new: what is open or focused stays
        return fill(this.scored, scoreButton(result.score));
      }
      const planes = planesOf(result);
      const plane = this.looks.chosen(planes);
      const picture = await store.picture(lookOf(result.id, plane));
      if (!still()) return;
      this.result = result;
      this.origins.of(result);
      this.#show(seen, picture, title(job));
      const down = exemplarOf(job)?.planes.some((each) => each.normals === "dx") ?? false;
      const map = mapOf(result);
      this.looks.show({ id: result.id, result: map, judged: map === result.id, planes, at: (each) => lookOf(result.id, each), down });
      this.softness.show(job, result);
      fill(this.scored, scoreButton(result.score));
      const method = job.options.method ? "" : result.told?.method;
      this.#headline(title(job), facts(method, size(...result.size), took(job)), [this.scored, this.#comparing(), ...resultActions(result, plane)]);
      return;
    }
    this.result = null;
    this.origins.of(null);
    this.softness.show(null);
    const number = job && busy(job) ? store.previews.get(job.id) : undefined;
    if (job) this.looks.show(null);
    if (job && number !== undefined) {
      const preview = await store.picture(`/api/jobs/${job.id}/preview.png?number=${number}`);
      if (still()) this.#show(`${job.id} ${number}`, preview, "Growing");
    } else if (exemplar && !(job && this.#shown.startsWith(job.id))) {
      if (this.#shown === exemplar.id && this.looks.of === exemplar.id) return;
      const planes = exemplar.planes.map((each) => each.name).filter((each) => each !== "mask");
      const at = (/** @type {string} */ plane) => viewOf(exemplar, LONGEST, plane);
      const picture = await store.picture(at(this.looks.chosen(planes)));
      if (!still()) return;
      this.#show(exemplar.id, picture, `Exemplar ${exemplar.name}`);
      const down = exemplar.planes.some((each) => each.normals === "dx");
      this.looks.show({ id: exemplar.id, result: null, planes, at, down });
    }
    if (still()) this.#headline(job ? title(job) : "Exemplar", job || !exemplar ? "" : size(exemplar.width, exemplar.height), []);
  }

  /** A switch that lays another result over half of this one. */
  #comparing() {
    const switched = button("Compare", () => {
      if (this.compare.on) this.#alone();
      else void this.#against(this.#neighbour());
    }, { icon: icon("compare"), class: "compare", "aria-pressed": "false", title: "Compare with another result: A and B" });
    return switched;
  }

  /** The result of the same exemplar that was made before this one, or else after it. */
  #neighbour() {
    const done = store.made.filter((job) => job.result && job.exemplars[0] === this.job?.exemplars[0]);
    const at = done.findIndex((job) => job.id === this.job?.id);
    return (done[at + 1] ?? done[at - 1])?.id;
  }

  /** @param {string | undefined} id of the job to compare with */
  async #against(id) {
    const job = store.jobs.get(id ?? "");
    if (!job?.result || !this.job || job.id === this.job.id) return complain("Grow another one first, to compare with.");
    await tried(async () => {
      const picture = await store.picture(store.thumb(job, LONGEST));
      if (!this.job) return;
      this.looks.plain();
      this.compare.show(picture, title(this.job), title(job));
      this.strip.other = job.id;
      this.strip.show();
      this.head.querySelector(".compare")?.setAttribute("aria-pressed", "true");
    });
  }

  #alone() {
    this.head.querySelector(".compare")?.setAttribute("aria-pressed", "false");
    this.compare.show(null);
    this.strip.other = null;
    this.strip.show();
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
   * @param {string} told
   * @param {(HTMLElement | null)[]} actions
   */
  #headline(name, told, actions) {
    fill(
      this.head,
      el("div", { class: "names" }, el("h2", { class: "one-line" }, name), el("p", { class: "quiet small number one-line" }, told)),
      store.sheet.some((id) => store.jobs.get(id)?.exemplars[0] === store.exemplar?.id) && button("Sheet", () => store.spreadOut(store.sheet), { title: "Back to the contact sheet" }),
      el("span", { class: "actions" }, this.looks.planes, actions),
    );
  }
}

customElements.define("result-view", ResultView);
