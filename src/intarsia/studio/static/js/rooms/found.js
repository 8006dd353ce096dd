/** Inspect: what the program sees in the exemplar, drawn over it, and why it would grow it so; crop it, mark what to avoid. */

import { get, post, viewOf } from "../core/api.js";
import { button, el, fill, Living } from "../core/dom.js";
import { store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { Brush, Kit } from "../paint/brush.js";
import { imageOf, keep, labelsOf } from "../paint/marks.js";
import { toolbar, toolKeys } from "../paint/tools.js";
import { segments } from "../parts/choice.js";
import { overlays, reasons } from "../parts/findings.js";
import { forEngine } from "../parts/material.js";
import { viewButtons } from "../parts/view-buttons.js";
import { Crop } from "../stage/crop.js";
import { Stage } from "../stage/stage.js";

/** @typedef {"look" | "crop" | "avoid"} Mode */

const kit = new Kit();
/** @type {Map<string, import("../paint/labels.js").Labels>} what is to be avoided, by exemplar */
const avoided = new Map();

export class FoundRoom extends Living {
  past = kit.past;
  stage = new Stage();
  panel = el("aside", { class: "panel", "aria-label": "Seen in the example" });
  tools = el("div", { class: "group" });
  told = el("div", { class: "group" });
  /** @type {Mode} */ mode = "look";
  /** @type {Set<string>} overlays that are switched on */
  on = new Set();
  crop = new Crop(this.stage, () => this.#tools());

  connectedCallback() {
    this.className = "paint";
    const { signal } = this.gone;
    const head = el("div", { class: "head" }, el("h2", {}, "Example"), viewButtons(this.stage, false));
    this.brush = new Brush(this.stage, kit, () => this.#avoided());
    kit.set({ value: 1 });
    toolKeys(kit, signal, 0);
    kit.history.addEventListener("change", () => void this.#send(), { signal });
    /** @type {[Mode, string][]} */ const modes = [["look", "Look"], ["crop", "Crop"], ["avoid", "Avoid"]];
    const choice = segments("Task", modes, () => this.mode, (mode) => [(this.mode = mode), this.#mode()], { wide: true });
    fill(this, el("section", { class: "half", "aria-label": "Example" }, head, this.stage), this.panel);
    fill(this.panel, el("div", { class: "fields padded" }, choice.element, this.tools, this.told));
    this.#mode();
    store.on(["exemplar"], () => void this.#show(), signal);
  }

  #avoided() {
    return labelsOf(avoided, "avoid", () => void this.#lay(), (value) => (value ? 0 : 1));
  }

  async #show() {
    const exemplar = store.exemplar;
    if (!exemplar) return;
    this.on.clear();
    this.crop.box = null;
    fill(this.told, el("p", { class: "quiet" }, "Looking …"));
    await tried(async () => {
      const picture = await store.picture(viewOf(exemplar));
      if (store.exemplar?.id !== exemplar.id) return;
      this.stage.show(picture, `Example ${exemplar.name}`, [exemplar.width, exemplar.height], viewOf(exemplar));
      this.#mode();
      const found = await get(`/api/exemplars/${exemplar.id}/found`);
      if (store.exemplar?.id !== exemplar.id) return;
      const turn = (/** @type {string} */ kind, /** @type {boolean} */ yes) => {
        if (yes) this.on.add(kind);
        else this.on.delete(kind);
        void this.#lay();
      };
      fill(this.told, overlays(found, turn), reasons(found));
    });
    if (this.told.textContent === "Looking …") fill(this.told);
  }

  /** Lay the overlays that are switched on over the exemplar, and what is avoided. */
  async #lay() {
    const exemplar = store.exemplar;
    if (!exemplar) return;
    await tried(async () => {
      const kinds = [...this.on];
      const drawn = await Promise.all(kinds.map((kind) => store.picture(`/api/exemplars/${exemplar.id}/found/${kind}.png`)));
      if (store.exemplar?.id !== exemplar.id) return;
      const marks = avoided.get(exemplar.id);
      this.stage.layers = drawn.map((picture) => ({ picture }));
      if (marks) this.stage.layers.push({ picture: marks.canvas, alpha: 0.75 });
      this.stage.draw();
    });
  }

  #mode() {
    const { mode, stage, brush, crop } = this;
    stage.tool = mode === "avoid" ? (brush ?? null) : mode === "crop" ? crop : null;
    stage.marks = mode === "avoid" ? (pen, view) => brush?.ring(pen, view) : mode === "crop" ? (pen, view) => crop.marks(pen, view) : null;
    stage.classList.toggle("drawing", mode !== "look");
    if (mode === "avoid" || imageOf(store.exemplar?.id ?? "", "avoid")) this.#avoided();
    this.#tools();
    void this.#lay();
  }

  #tools() {
    const { mode, crop } = this;
    if (mode === "look") {
      const { id, planes } = store.exemplar ?? { id: "", planes: [] };
      const edits = el("div", { class: "pairs" }, this.#edit("Straighten", { straighten: true }), this.#edit("Flatten light", { flatten: true }));
      return fill(this.tools, edits, forEngine("the example", `/api/exemplars/${id}`, planes.map((plane) => plane.name)));
    }
    if (mode === "avoid") return fill(this.tools, el("p", { class: "quiet" }, "Brush over what shall never be used in growing."), toolbar(kit));
    const box = crop.box;
    const says = box ? `${box.width} × ${box.height} px from ${box.x}, ${box.y}` : "Draw a rectangle over the part to keep.";
    const cut = this.#edit("Crop", box ? { crop: [box.x, box.y, box.width, box.height] } : {});
    cut.disabled = !box;
    fill(this.tools, el("p", { class: "quiet number" }, says), cut);
  }

  /** A button that makes a new exemplar of this one.
   * @param {string} name @param {Record<string, any>} how */
  #edit(name, how) {
    const edit = button(name, () => {
      const exemplar = store.exemplar;
      if (!exemplar) return;
      edit.disabled = true;
      void tried(async () => store.choose(await post(`/api/exemplars/${exemplar.id}/edit`, how))).finally(() => (edit.disabled = false));
    }, { class: "framed" });
    return edit;
  }

  /** Send what is avoided, for the next growing. */
  async #send() {
    const exemplar = store.exemplar;
    const labels = avoided.get(exemplar?.id ?? "");
    if (!exemplar || !labels) return;
    await keep(exemplar.id, "avoid", labels, (value) => (value ? 0 : 255));
    store.tell("exemplar");
  }
}

customElements.define("found-room", FoundRoom);
