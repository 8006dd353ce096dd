/** What is looked at: the exemplar, a picture as it grows, or a result; on the stage, with what can be done with it. */

import { lookOf, LONGEST, Refused, viewOf } from "../core/api.js";
import { button, el, fill, Living } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { exemplarOf, mapOf, planesOf, store } from "../core/store.js";
import { complain, tried } from "../core/toast.js";
import { busy, called, doing, facts, size, state, title, took } from "../core/words.js";
import { Stage } from "../stage/stage.js";
import { awaited, grey, wantedSize } from "./awaited.js";
import { Compare } from "./compare.js";
import { Looks } from "./looks.js";
import { Origins } from "./origins.js";
import { Places } from "./places.js";
import { showProgress } from "./progress.js";
import { resultActions } from "./result-actions.js";
import { scoreButton } from "./score.js";
import { Sheet } from "./sheet.js";
import { Softness } from "./softness.js";
import { Strip } from "./strip.js";
import { viewButtons } from "./view-buttons.js";

/** @typedef {import("../core/types.js").Job} Job */

export class ResultView extends Living {
  stage = new Stage();
  head = el("div", { class: "head" });
  progress = el("div", { class: "progress", hidden: true });
  bar = el("div", { class: "stage-bar" });
  strip = new Strip();
  compare = new Compare(this.stage);
  looks = new Looks(this.stage, () => [(this.#shown = ""), void this.#update()]);
  softness = new Softness();
  origins = new Origins();
  places = new Places(this.stage);
  /** Whether the headline has the button to go on from a result. */
  onward = true;
  scored = el("span");
  waiting = el("p", { class: "awaited number" });
  /** @type {Job | null} */ job = null;
  /** @type {import("../core/types.js").Result | null} */ result = null;
  #turn = 0;
  #shown = "";
  #clock = 0;
  /** The previews of a job up to the last one, each over those before it: where nothing has grown yet, its draft is seen. */
  #growing = { id: "", number: 0, canvas: grey() };

  connectedCallback() {
    this.className = "result-view";
    this.stage.append(this.looks.legend, this.origins.place, this.waiting);
    this.#clock = window.setInterval(() => busy(this.job) && this.#wait(), 1000);
    fill(this.bar, viewButtons(this.stage), this.looks.element, this.softness.element, this.progress);
    this.stage.addEventListener("hover", (e) => {
      this.origins.tell(e instanceof CustomEvent && !this.stage.draft ? e.detail : null);
    });
    fill(this, this.head, this.stage, this.bar, this.strip, new Sheet());
    this.strip.act = (id) => (this.compare.on ? void this.#against(id) : store.look(id));
    store.on(["chosen", "jobs", "exemplar", "preview"], () => void this.#update(), this.gone.signal);
  }

  disconnectedCallback() {
    clearInterval(this.#clock);
    super.disconnectedCallback();
  }

  async #update() {
    const turn = ++this.#turn;
    this.job = store.jobs.get(store.chosen ?? "") ?? null;
    if (this.compare.on && this.job?.result !== this.result?.id) this.#alone();
    this.#wait();
    try {
      await this.#picture(() => turn === this.#turn);
    } catch (error) {
      const over = error instanceof Refused && error.status === 204; // it ended meanwhile: its result comes
      if (turn === this.#turn && !over) complain(error);
    }
  }

  /** Tell how far the job is, and what it waits for. */
  #wait() {
    if (this.result && !this.job?.result) { // what can be taken is not of this one
      fill(this.head);
      this.#shown = ""; // so that the same result is shown again, should the job end with it
    }
    showProgress(this.progress, this.job);
    this.waiting.textContent = awaited(this.job);
  }

  /** Show what belongs to the chosen job, unless something else was chosen meanwhile.
   * @param {() => boolean} still */
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
        return this.#judge(job, result);
      }
      const planes = planesOf(result);
      const plane = this.looks.chosen(planes);
      const path = lookOf(result.id, plane, Math.max(...result.size) > LONGEST ? LONGEST / 2 : LONGEST); // parts are finer
      const picture = await store.picture(path);
      if (!still()) return;
      this.result = result;
      this.origins.of(result);
      this.#show(seen, picture, title(job), result.size, path);
      const down = exemplarOf(job)?.planes.some((each) => each.normals === "dx") ?? false;
      const map = mapOf(result);
      this.looks.show({ id: result.id, result: map, judged: map === result.id, planes, at: (each) => lookOf(result.id, each), down });
      this.softness.show(job, result);
      this.#judge(job, result);
      this.places.goOn(job, result);
      const method = called(job.options.method ?? result.told?.method ?? "");
      this.#headline(title(job), facts(title(job).includes(method) ? "" : method, size(...result.size), took(job)), [this.scored, this.#comparing(), ...resultActions(result, plane, this.onward)]);
      return;
    }
    this.result = null;
    this.origins.of(null);
    this.softness.show(null);
    const number = job && busy(job) ? store.previews.get(job.id) : undefined;
    const seed = job && job.verb !== "render" ? `seed ${job.options.seed ?? 0}` : "";
    if (job) this.#headline(busy(job) ? `${doing(job)} ...` : state(job), facts(called(job.options.method ?? ""), seed, size(...wantedSize(job))), []);
    if (job) this.looks.show(null);
    if (job && number !== undefined) {
      const preview = await store.picture(`/api/jobs/${job.id}/preview.png?number=${number}`);
      const laid = this.#laid(job.id, number, preview);
      if (still()) this.#show(`${job.id} ${number}`, laid, doing(job), wantedSize(job));
    } else if (job) {
      if (!this.#shown.startsWith(job.id)) this.#show(`${job.id} 0`, grey(), doing(job), wantedSize(job));
    } else if (exemplar) {
      if (this.#shown === exemplar.id && this.looks.of === exemplar.id) return;
      const planes = exemplar.planes.map((each) => each.name).filter((each) => each !== "mask");
      const at = (/** @type {string} */ plane) => viewOf(exemplar, LONGEST, plane);
      const path = at(this.looks.chosen(planes));
      const picture = await store.picture(path);
      if (!still()) return;
      this.#show(exemplar.id, picture, `Example ${exemplar.name}`, [exemplar.width, exemplar.height], path);
      const down = exemplar.planes.some((each) => each.normals === "dx");
      this.looks.show({ id: exemplar.id, result: null, planes, at, down });
    }
    if (!job && still()) this.#headline("Example", exemplar ? size(exemplar.width, exemplar.height) : "", []);
  }

  /** @param {string} id of a job @param {number} number @param {ImageBitmap} preview */
  #laid(id, number, preview) {
    if (this.#growing.id !== id) this.#growing = { id, number: 0, canvas: new OffscreenCanvas(preview.width, preview.height) };
    const { canvas, number: last } = this.#growing;
    if (number > last) canvas.getContext("2d")?.drawImage(preview, 0, 0, canvas.width, canvas.height);
    this.#growing.number = Math.max(number, last);
    return canvas;
  }

  /** Tell how good a result is.
   * @param {Job} job @param {import("../core/types.js").Result} result */
  #judge(job, result) {
    fill(this.scored, scoreButton(result, (part, says, spots) => this.places.show({ job, result, part, spots }, says)));
  }

  /** A switch that lays another result over half of this one. */
  #comparing() {
    const switched = button("Compare", () => {
      if (this.compare.on) this.#alone();
      else void tried(async () => this.#against(await this.#neighbour()));
    }, { icon: icon("compare"), class: "compare", "aria-pressed": "false", title: "Compare with another result: A and B" });
    return switched;
  }

  /** A result of the same size: that which this one was made of, or of the same exemplar the one before, or else after it. */
  async #neighbour() {
    const from = this.job && exemplarOf(this.job)?.from;
    const done = store.made.filter((job) => job.result && (job.exemplars[0] === this.job?.exemplars[0] || job.result === from));
    const at = done.findIndex((job) => job.id === this.job?.id);
    for (const job of [...done.slice(at + 1), ...done.slice(0, at).reverse()]) {
      if (String(await this.#size(job)) === String(this.result?.size)) return job.id;
    }
    return undefined;
  }

  /** @param {Job} job that is done */
  async #size(job) {
    return (await store.result(job.result ?? "", job.score)).size;
  }

  /** @param {string | undefined} id of the job to compare with */
  async #against(id) {
    const job = store.jobs.get(id ?? "");
    if (!job?.result || !this.job || job.id === this.job.id) return complain("Grow another one of this size first, to compare with.");
    await tried(async () => {
      const [path, sides] = [store.thumb(job, LONGEST), await this.#size(job)];
      const picture = await store.picture(path);
      if (!this.job || !this.result) return;
      if (String(sides) !== String(this.result.size)) return complain(`This one has ${size(...sides)} px, and A ${size(...this.result.size)}: compare two of the same size.`);
      this.looks.plain();
      const before = job.result === exemplarOf(this.job)?.from;
      this.compare.show(picture, before ? "after" : title(this.job), before ? `before: ${title(job)}` : title(job), path);
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

  /** @param {string} what @param {import("../stage/stage.js").Drawable} picture @param {string} name
   * @param {[number, number]} sides of all of it in px @param {string} [path] */
  #show(what, picture, name, sides, path) {
    this.#shown = what;
    this.stage.draft = this.job !== null && this.job.state !== "done";
    this.places.show(null);
    this.stage.show(picture, name, sides, path);
    this.dispatchEvent(new Event("shown"));
  }

  /** @param {string} name @param {string} told @param {(HTMLElement | null)[]} actions */
  #headline(name, told, actions) {
    fill(
      this.head,
      el("div", { class: "names" }, el("h2", { class: "one-line", title: name }, name), el("p", { class: "quiet small number one-line", title: told }, told)),
      store.sheet.some((id) => store.jobs.get(id)?.exemplars[0] === store.exemplar?.id) && button("Sheet", () => store.spreadOut(store.sheet), { title: "Back to the contact sheet" }),
      el("span", { class: "actions" }, this.looks.planes, actions),
    );
  }
}

customElements.define("result-view", ResultView);
