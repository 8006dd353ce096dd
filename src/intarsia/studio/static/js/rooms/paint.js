/** Paint: labels over the exemplar on the left, labels of what is wanted on the right; then each region is grown. */

import { numbers, viewOf } from "../core/api.js";
import { button, el, fill } from "../core/dom.js";
import { Settings } from "../core/settings.js";
import { store } from "../core/store.js";
import { complain, tried } from "../core/toast.js";
import { Brush, Kit } from "../paint/brush.js";
import { COLOURS, Labels } from "../paint/labels.js";
import { keep, restore } from "../paint/marks.js";
import { send } from "../paint/send.js";
import { toolbar, toolKeys } from "../paint/tools.js";
import { beside } from "../parts/beside.js";
import { field, refused } from "../parts/field.js";
import { methodPicker } from "../parts/methods.js";
import { choicesOf } from "../parts/options.js";
import { seedField } from "../parts/seed.js";
import { wrapChoice } from "../parts/wrap.js";
import { pixelsOf, sizeField } from "../parts/size.js";
import { viewButtons } from "../parts/view-buttons.js";
import { Stage } from "../stage/stage.js";

/** @type {Map<string, {source: Labels, target: Labels}>} what was painted, by exemplar */
const painted = new Map();
const kit = new Kit();
const painting = new Settings("paint", kit.past);
const NAMED = 6;
/** px a side of what is painted. */
const MOST = 8192;

export class PaintRoom extends HTMLElement {
  past = kit.past;
  left = new Stage();
  right = new Stage();
  panel = el("aside", { class: "panel", "aria-label": "Painting" });
  #gone = new AbortController();

  connectedCallback() {
    this.className = "paint";
    const { signal } = this.#gone;
    const pair = el("div", { class: "pair" }, half("Exemplar", this.left), half("Wanted", this.right));
    const go = button("Grow", () => void this.grow(), { class: "strong big" });
    const { main, buttons } = beside(pair, go, "Paint on", signal);
    fill(this, main, this.panel);
    this.#panel(buttons);
    new Brush(this.left, kit, () => this.#labels()?.source ?? null);
    new Brush(this.right, kit, () => this.#labels()?.target ?? null);
    toolKeys(kit, signal, NAMED);
    store.on(["exemplar"], () => void this.#show(), signal);
    painting.addEventListener("change", () => this.#size(), { signal });
    kit.history.addEventListener("change", () => this.#keep(), { signal });
    kit.addEventListener("change", () => [this.left.draw(), this.right.draw()], { signal });
  }

  disconnectedCallback() {
    this.#gone.abort();
  }

  #labels() {
    return painted.get(store.exemplar?.id ?? "");
  }

  async #show() {
    const exemplar = store.exemplar;
    if (!exemplar) return;
    const { id, width, height } = exemplar;
    if (!painted.has(id)) {
      const begun = { source: new Labels(width, height), target: this.#blank() };
      painted.set(id, begun);
      await Promise.all([restore(id, "source", begun.source), restore(id, "target", begun.target)]);
    }
    await tried(async () => {
      const picture = await store.picture(viewOf(exemplar));
      const labels = this.#labels();
      if (store.exemplar?.id !== id || !labels) return;
      this.left.layers = [{ picture: labels.source.canvas, alpha: 0.6 }];
      this.left.show(picture, `Labels of ${exemplar.name}`, [width, height], viewOf(exemplar));
      this.#size();
    });
  }

  /** Keep what was just painted. */
  #keep() {
    const labels = this.#labels();
    if (!store.exemplar || !labels) return;
    const name = kit.history.last === labels.source ? "source" : "target";
    void keep(store.exemplar.id, name, labels[name]);
  }

  #blank() {
    const [wide, high] = pixelsOf(painting.options);
    return new Labels(Math.min(MOST, wide), Math.min(MOST, high), true);
  }

  /** Make the target as large as it is asked for; what was painted stays where it was. */
  #size() {
    const labels = this.#labels();
    if (!labels) return;
    const next = this.#blank();
    const { width, height } = labels.target;
    if (next.width !== width || next.height !== height) {
      next.lay(labels.target);
      labels.target = next;
    }
    this.right.show(labels.target.canvas, "Labels that are wanted");
  }

  /** @param {HTMLElement} buttons to grow, and from the result back and on */
  #panel(buttons) {
    const colours = COLOURS.slice(0, NAMED).map(([r, g, b], n) => {
      const swatch = el("span", { class: "swatch" }, n + 1);
      swatch.style.background = `rgb(${r} ${g} ${b})`;
      return el("button", {
        type: "button", class: "button", value: String(n), "aria-label": `Label ${n + 1}`, title: `Label ${n + 1} (${n + 1})`,
        onclick: () => kit.set({ value: n, tool: kit.tool === "fill" ? "fill" : "brush" }),
      }, swatch);
    });
    const show = () => {
      for (const each of colours) each.setAttribute("aria-pressed", String(Number(each.value) === kit.value));
    };
    kit.addEventListener("change", show, { signal: this.#gone.signal });
    show();
    const wrap = wrapChoice(painting);
    const weight = store.schema?.verbs.paint?.find((o) => o.name === "weight");
    fill(
      this.panel,
      buttons,
      el(
        "div",
        { class: "fields" },
        el("p", { class: "quiet" }, "Mark what is what in the example, then paint with the same labels where each shall be."),
        el("div", { class: "group" }, el("div", { class: "headed" }, el("h3", {}, "Label"), this.#proposing()), el("div", { class: "palette" }, colours)),
        toolbar(kit),
        sizeField(painting),
        el("div", { class: "row" }, el("span", {}, "Tiles"), wrap.element),
        seedField(painting),
        methodPicker(painting, choicesOf("paint", "method")),
        weight && el("div", { class: "options" }, field(weight, painting)),
      ),
    );
  }

  /** A button that marks the exemplar as its segments are grouped. */
  #proposing() {
    const propose = button("Propose", () => {
      propose.disabled = true;
      void tried(() => this.#propose()).finally(() => (propose.disabled = false));
    }, { class: "framed", title: "Mark the example by its parts that look alike" });
    return propose;
  }

  async #propose() {
    const exemplar = store.exemplar;
    const labels = this.#labels()?.source;
    if (!exemplar || !labels) return;
    const proposed = await numbers(`/api/exemplars/${exemplar.id}/found/labels.png`);
    const before = labels.data.slice();
    labels.lay(proposed);
    kit.history.note(labels, before);
    this.left.draw();
  }

  /** Send both label pictures, and ask for what is painted. */
  async grow() {
    const exemplar = store.exemplar;
    const labels = this.#labels();
    if (!exemplar || !labels || refused(this.panel)) return;
    const [wide, high] = pixelsOf(painting.options);
    if (Math.max(wide, high) > MOST) return complain(`Size: ${wide}x${high} cannot be painted; give at most ${MOST} px a side.`);
    const marked = new Set(labels.source.data);
    const wanted = [...new Set(labels.target.data)].find((label) => !marked.has(label));
    if (wanted !== undefined) {
      const name = `Label ${wanted + 1}`;
      return complain(`${name} is wanted, but marked nowhere in the example: paint over what it is on the left, or press Propose.`);
    }
    await tried(async () => {
      const [source, target] = [await send(labels.source), await send(labels.target)];
      const { size, ...options } = painting.options;
      const job = await store.start("paint", [exemplar.id], { ...options, labels: source, target });
      store.look(job.id);
    });
  }
}

/** @param {string} name @param {Stage} stage */
function half(name, stage) {
  return el("section", { class: "half", "aria-label": name }, el("div", { class: "head" }, el("h2", {}, name), viewButtons(stage, false)), stage);
}

customElements.define("paint-room", PaintRoom);
