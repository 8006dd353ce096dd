/** Grow: the exemplar on the left, the picture in the middle, what can be set on the right, and one button. */

import { button, el, fill, follow, Living } from "../core/dom.js";
import { kept } from "../core/kept.js";
import { growing } from "../core/settings.js";
import { store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { about } from "../core/words.js";
import { imageOf } from "../paint/marks.js";
import { segments } from "../parts/choice.js";
import { estimate } from "../parts/estimate.js";
import { refused } from "../parts/field.js";
import { methodPicker, parameterForm } from "../parts/methods.js";
import { choicesOf, optionGroups } from "../parts/options.js";
import { variants } from "../parts/variants.js";
import { ExemplarCard } from "../parts/exemplar-card.js";
import { ResultView } from "../parts/result-view.js";
import { seedField } from "../parts/seed.js";
import { undoButtons } from "../parts/undo.js";
import { wrapChoice } from "../parts/wrap.js";
import { inPixels, sizeField } from "../parts/size.js";

export class GrowRoom extends Living {
  past = growing.past;

  /** @returns {import("../parts/variants.js").Many} */
  get many() {
    return kept.of().many ?? "1";
  }

  connectedCallback() {
    this.className = "grow three";
    this.#draw();
    store.on(["exemplar"], () => this.#panel(), this.gone.signal);
    addEventListener("keydown", (e) => this.#key(e), { signal: this.gone.signal });
  }

  #draw() {
    this.panel = el("aside", { class: "panel", "aria-label": "Settings" });
    fill(this, new ExemplarCard(), new ResultView(), this.panel);
  }

  #panel() {
    if (!this.panel) return;
    const wrap = wrapChoice(growing);
    const soon = el("p", { class: "quiet small number", role: "status" });
    const told = () => (soon.textContent = store.exemplar ? `Takes ${about(estimate(this.#asked()))}` : "");
    follow(growing, soon, told);
    for (const topic of ["jobs", "exemplar"]) follow(store, soon, told, topic);
    fill(
      this.panel,
      el("div", { class: "do" }, button("Grow", () => void this.grow(), { class: "strong big" }), undoButtons(growing.past)),
      el(
        "div",
        { class: "fields" },
        sizeField(growing),
        soon,
        el("div", { class: "row" }, el("span", {}, "Tiles"), wrap.element),
        seedField(growing),
        el("div", { class: "row" }, el("span", {}, "Make"), this.#many()),
        methodPicker(growing, choicesOf("grow", "method")),
        parameterForm(growing),
        optionGroups("grow", growing),
      ),
    );
  }

  #many() {
    /** @type {[import("../parts/variants.js").Many, string][]} */
    const choices = [["1", "1"], ["4", "4"], ["9", "9"], ["methods", "Methods"]];
    const many = segments("Make", choices, () => this.many, (value) => [kept.set({ many: value }), growing.dispatchEvent(new Event("change"))], { wide: true });
    many.element.title = "So many seeds, or one with each method, side by side";
    return many.element;
  }

  /** @returns {Pick<import("../core/types.js").Job, "verb" | "exemplars" | "options">[]} what is set, a job for each picture */
  #asked() {
    const name = store.exemplar?.id ?? "";
    const mask = imageOf(name, "avoid");
    const all = variants(inPixels(growing.options), this.many, choicesOf("grow", "method"));
    return all.map((options) => ({ verb: "grow", exemplars: [name], options: mask ? { ...options, mask: [mask] } : options }));
  }

  /** Ask for what is set. */
  async grow() {
    if (!store.exemplar || !this.panel || refused(this.panel)) return;
    await tried(async () => {
      const jobs = [];
      for (const { verb, exemplars, options } of this.#asked()) jobs.push(await store.start(verb, exemplars, options));
      if (jobs.length > 1) store.spreadOut(jobs.map((job) => job.id));
      else store.look(jobs[0]?.id ?? null);
    });
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (!(event.ctrlKey || event.metaKey) || event.key !== "Enter") return;
    event.preventDefault();
    void this.grow();
  }
}

customElements.define("grow-room", GrowRoom);
