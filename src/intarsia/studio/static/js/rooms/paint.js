/** Paint: labels over the exemplar on the left, what is wanted on the right: painted with what is marked, and grown meanwhile. */

import { numbers, picture, Refused, viewOf } from "../core/api.js";
import { button, el, fill, Living } from "../core/dom.js";
import { kept } from "../core/kept.js";
import { Settings } from "../core/settings.js";
import { store } from "../core/store.js";
import { complain, tried } from "../core/toast.js";
import { Brush, Kit } from "../paint/brush.js";
import { COLOURS, FLAT, Labels } from "../paint/labels.js";
import { keep, restore } from "../paint/marks.js";
import { LABELS, nameOf, palette } from "../paint/palette.js";
import { send } from "../paint/send.js";
import { textures } from "../paint/textures.js";
import { toolbar, toolKeys } from "../paint/tools.js";
import { beside } from "../parts/beside.js";
import { pick } from "../parts/bring.js";
import { segments } from "../parts/choice.js";
import { field, refused } from "../parts/field.js";
import { methodPicker } from "../parts/methods.js";
import { choicesOf } from "../parts/options.js";
import { seedField } from "../parts/seed.js";
import { wrapChoice } from "../parts/wrap.js";
import { pixelsOf, sizeField } from "../parts/size.js";
import { viewButtons } from "../parts/view-buttons.js";
import { Stage } from "../stage/stage.js";

/** @typedef {{source: Labels, target: Labels, result?: {picture: ImageBitmap, known: Uint8Array}}} Painted `result`: of known labels */
/** @type {Map<string, Painted>} by exemplar */
const painted = new Map();
const kit = new Kit();
const painting = new Settings("paint", kit.past);
const MOST = 8192; // px a side of what is painted
const MOMENT = 60; // ms without a change, so that a number that is typed, or undo again and again, is one
/** Labels that another picture is all of: number -> id of the example. */
const others = () => Object.entries(/** @type {Record<string, string>} */ (kept.of(store.exemplar?.id).others ?? {})).filter(([, id]) => store.exemplars.some((e) => e.id === id));
let live = true; // whether the result is shown while it is painted
let patience = 60; // how often a first look that is not there yet is asked for again: on a new computer it takes two minutes

export class PaintRoom extends Living {
  past = kit.past;
  left = new Stage();
  right = new Stage();
  panel = el("aside", { class: "panel", "aria-label": "Painting" });
  palette = palette(kit);
  another = el("select", { class: "field", "aria-label": "Add a picture", onchange: () => this.#add(this.another.value) });
  told = el("span", { class: "corner low left", role: "status" });
  /** @type {Promise<unknown>} when all is there that was painted before */ restored = Promise.resolve();
  #asked = new AbortController();

  connectedCallback() {
    this.className = "paint";
    const { signal } = this.gone;
    const look = segments("Wanted", [["labels", "Labels"], ["result", "Result"]], () => (live ? "result" : "labels"), (seen) => {
      live = seen === "result";
      void [this.#see(), this.#draft()];
    });
    this.right.append(this.told);
    const pair = el("div", { class: "pair" }, half("Example", this.left), half("Wanted", this.right, look.element));
    const go = button("Grow", () => void this.grow(), { class: "strong big" });
    const { main, buttons } = beside(pair, go, "Paint on", [kit.past], signal);
    fill(this, main, this.panel);
    this.#panel(buttons);
    new Brush(this.left, kit, () => this.#labels()?.source ?? null);
    new Brush(this.right, kit, () => this.#labels()?.target ?? null);
    toolKeys(kit, signal, LABELS);
    store.on(["exemplar"], () => void this.#show(), signal);
    store.on(["exemplar", "exemplars"], () => this.#offer(), signal);
    painting.addEventListener("change", () => [this.#size(), void this.#draft()], { signal });
    kit.history.addEventListener("change", () => this.#keep(), { signal });
    kit.addEventListener("change", () => [this.left.draw(), this.right.draw()], { signal });
  }

  disconnectedCallback() {
    super.disconnectedCallback();
    this.#asked.abort();
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
      this.restored = Promise.all([restore(id, "source", begun.source), restore(id, "target", begun.target)]);
    }
    await this.restored;
    await tried(async () => {
      const seen = await store.picture(viewOf(exemplar));
      const labels = this.#labels();
      if (store.exemplar?.id !== id || !labels) return;
      this.left.layers = [{ picture: labels.source.canvas, alpha: 0.6 }];
      this.left.show(seen, `Labels of ${exemplar.name}`, [width, height], viewOf(exemplar));
      this.#size();
      this.#see();
      void this.#dip();
      void this.#draft();
    });
  }

  /** Keep what was just painted, and show what comes of it. */
  #keep() {
    const labels = this.#labels();
    if (!store.exemplar || !labels || !kit.history.last) return;
    const name = kit.history.last === labels.source ? "source" : "target";
    if (name === "source") void this.#dip();
    void keep(store.exemplar.id, name, labels[name]);
    void this.#draft();
  }

  /** Let labels look as what is marked with them. */
  async #dip() {
    const [labels, { picture: seen }, more] = [this.#labels(), this.left, others()];
    if (!labels || !(seen instanceof ImageBitmap)) return;
    const found = labels.source.values.length > 1 || more.length ? textures(labels.source, seen) : []; // else nothing is marked yet
    for (const [n, id] of more) {
      const all = await store.picture(viewOf(exemplarBy(id)));
      found[Number(n)] = textures(new Labels(all.width, all.height), all)[0];
    }
    if (labels !== this.#labels()) return;
    labels.target.inks = FLAT.map((flat, n) => found[n] ?? flat);
    labels.target.paint();
    this.palette.dip(labels.target.inks);
    this.right.draw();
  }

  /** Offer the pictures that are open, and a way to open more. */
  #offer() {
    const free = store.exemplars.filter((e) => e.id !== store.exemplar?.id && !others().some(([, id]) => id === e.id));
    const choices = free.map((e) => el("option", { value: e.id }, e.name, e.planes.length > 1 && " with maps"));
    fill(this.another, el("option", { value: "" }, "Add a picture …"), choices, el("option", { value: "open" }, "Open one first …"));
  }

  /** Take all of another picture as one more label.
   * @param {string} id of its example, or the wish to open one */
  #add(id) {
    const [labels, exemplar] = [this.#labels(), store.exemplar?.id];
    this.another.value = "";
    if (!labels || id === "open") return pick();
    const taken = [0, ...labels.source.values, ...others().map(([n]) => Number(n))];
    const n = COLOURS.slice(0, LABELS).findIndex((_, each) => !taken.includes(each));
    if (n < 0) return complain(`All ${LABELS} labels are taken.`);
    const put = (/** @type {string | undefined} */ now) => [kept.set({ others: { ...kept.of(exemplar).others, [n]: now } }, exemplar), this.#offer(), void this.#dip(), void this.#draft()];
    kit.history.add({ labels: null, back: () => put(undefined), again: () => put(id) }, true);
    kit.set({ value: n });
  }

  /** Show the result where there is one, and over it what was painted since; or the labels. */
  #see() {
    const { target, result: seen } = this.#labels() ?? {};
    if (!target) return;
    const result = live ? seen : undefined;
    target.known = result?.known ?? new Uint8Array();
    target.paint();
    this.right.layers = result ? [{ picture: target.canvas }] : [];
    this.right.show(result?.picture ?? target.canvas, result ? "What is wanted" : "Labels that are wanted", [target.width, target.height]);
  }

  /** Ask for a first look at the result, unless more is painted in a moment. */
  async #draft() {
    this.#asked.abort();
    const { signal } = (this.#asked = new AbortController());
    const [exemplar, labels] = [store.exemplar, this.#labels()];
    const tell = (/** @type {string} */ line) => signal.aborted || (this.told.textContent = line);
    await new Promise((after) => setTimeout(after, MOMENT));
    const lacking = labels && live ? this.#lacking(labels) : "";
    const unmarked = labels && labels.source.values.length < 2 && !others().length;
    tell(lacking || (unmarked ? "Mark what is what on the left, or press Propose; then paint here." : live ? "Making a first look …" : ""));
    if (signal.aborted || !live || !exemplar || !labels || lacking || unmarked) return;
    const known = labels.target.data.slice();
    try {
      const asked = { verb: "paint", exemplars: [exemplar.id, ...others().map(([, each]) => each)], options: await this.#options(labels) };
      for (const [path, line] of /** @type {const} */ ([["/api/drafts", "A first look"], ["/api/drafts?fine", "A closer look"]])) {
        const seen = await picture(path, signal, asked);
        if (signal.aborted) return;
        labels.result = { picture: seen, known };
        tell(line);
        this.#see();
        await new Promise((after) => setTimeout(after, 25 * MOMENT)); // until the hand rests
        if (signal.aborted) return;
      }
    } catch (error) {
      const none = error instanceof Refused && error.status === 204;
      tell(none ? "" : String(error instanceof Error ? error.message : error));
      if (none && patience-- > 0) setTimeout(() => signal.aborted || void this.#draft(), 50 * MOMENT);
    }
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
    if (next.width === width && next.height === height) return;
    next.inks = labels.target.inks;
    next.lay(labels.target);
    Object.assign(labels, { target: next, result: undefined });
    this.#see();
  }

  /** @param {HTMLElement} buttons to grow, and from the result back and on */
  #panel(buttons) {
    const weight = store.schema?.verbs.paint?.find((o) => o.name === "weight");
    fill(
      this.panel,
      buttons,
      el(
        "div",
        { class: "fields" },
        el("p", { class: "quiet" }, "Mark what is what in the example, let Propose do it, or add a picture; then paint with it where you want it."),
        el("div", { class: "group" }, this.palette.element, this.another, this.#proposing()),
        toolbar(kit),
        sizeField(painting),
        el("div", { class: "row" }, el("span", {}, "Tiles"), wrapChoice(painting).element),
        seedField(painting),
        methodPicker(painting, choicesOf("paint", "method")),
        weight && el("div", { class: "options" }, field(weight, painting)),
      ),
    );
  }

  /** A button that marks the exemplar by so many things that look alike. */
  #proposing() {
    const count = el("input", { class: "field", type: "number", required: true, min: "2", max: String(LABELS), step: "1", value: "2", "aria-label": "How many things" });
    const act = async () => {
      const [exemplar, labels] = [store.exemplar, this.#labels()?.source];
      if (!exemplar || !labels || refused(row)) return;
      const proposed = await numbers(`/api/exemplars/${exemplar.id}/labels/${count.value}.png`);
      const before = labels.data.slice();
      labels.lay(proposed);
      kit.history.note(labels, before);
    };
    const propose = button("Propose", () => {
      propose.disabled = true;
      void tried(act).finally(() => (propose.disabled = false));
    }, { class: "framed", title: "Mark the example by what looks alike" });
    const row = el("div", { class: "things" }, el("span", {}, "How many things"), count, propose);
    return row;
  }

  /** Why nothing can be grown, if so.
   * @param {{source: Labels, target: Labels}} labels */
  #lacking({ source, target }) {
    const marked = [...source.values, ...others().map(([n]) => Number(n))];
    const wanted = target.values.filter((label) => !marked.includes(label)).map(nameOf)[0];
    return wanted ? `${wanted} is wanted, but marked nowhere in the example: paint over what it is on the left, or press Propose.` : "";
  }

  /** What is asked for, once both label pictures are there.
   * @param {{source: Labels, target: Labels}} labels */
  async #options({ source, target }) {
    const wholes = others().map(([n, id]) => {
      const { width, height } = exemplarBy(id);
      const whole = new Labels(width, height);
      whole.data.fill(Number(n));
      return whole;
    });
    const [wanted, ...marked] = await Promise.all([target, source, ...wholes].map((each) => send(each)));
    const { size, ...options } = painting.options;
    return { ...options, labels: marked, target: wanted };
  }

  /** Send both label pictures, and ask for what is painted. */
  async grow() {
    await this.restored;
    const [exemplar, labels] = [store.exemplar, this.#labels()];
    if (!exemplar || !labels || refused(this.panel)) return;
    const [wide, high] = pixelsOf(painting.options);
    if (Math.max(wide, high) > MOST) return complain(`Size: ${wide}x${high} cannot be painted; give at most ${MOST} px a side.`);
    if (this.#lacking(labels)) return complain(this.#lacking(labels));
    this.#asked.abort();
    await tried(async () => store.look((await store.start("paint", [exemplar.id, ...others().map(([, id]) => id)], await this.#options(labels))).id));
  }
}

/** @param {string} id of an example that is open */
const exemplarBy = (id) => /** @type {import("../core/types.js").Exemplar} */ (store.exemplars.find((e) => e.id === id));

/** @param {string} name @param {Stage} stage @param {HTMLElement} [look] how it is looked at */
function half(name, stage, look) {
  return el("section", { class: "half", "aria-label": name }, el("div", { class: "head" }, el("h2", {}, name), look, viewButtons(stage, false)), stage);
}

customElements.define("paint-room", PaintRoom);
