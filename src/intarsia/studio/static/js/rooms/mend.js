/** Mend: brush over what must go, drag the border outwards, or make the picture tile. */

import { viewOf } from "../core/api.js";
import { button, el, fill, follow, Living, there } from "../core/dom.js";
import { kept } from "../core/kept.js";
import { Settings } from "../core/settings.js";
import { store } from "../core/store.js";
import { complain, tried } from "../core/toast.js";
import { Brush, Kit } from "../paint/brush.js";
import { keep, labelsOf } from "../paint/marks.js";
import { send } from "../paint/send.js";
import { toolbar, toolKeys } from "../paint/tools.js";
import { beside } from "../parts/beside.js";
import { segments } from "../parts/choice.js";
import { refused } from "../parts/field.js";
import { methodPicker } from "../parts/methods.js";
import { choicesOf } from "../parts/options.js";
import { Rim } from "../parts/rim.js";
import { seedField } from "../parts/seed.js";
import { undoButtons } from "../parts/undo.js";
import { viewButtons } from "../parts/view-buttons.js";
import { Margins } from "../stage/margins.js";
import { Stage } from "../stage/stage.js";

/** @typedef {"heal" | "extend" | "tile"} Mode */

const kit = new Kit();
/** @type {Map<string, import("../paint/labels.js").Labels>} what is to be healed, by exemplar */
const holes = new Map();
/** @type {Record<Mode, Settings>} */
const settings = { heal: new Settings("heal", kit.past), extend: new Settings("extend"), tile: new Settings("tile") };
const ANOTHER = 0.1; // tolerance of what another seed was asked for: without one the best pieces are taken, and always the same
const task = {
  /** @returns {Mode} */
  get mode() {
    return kept.of().task ?? "heal";
  },
  set mode(mode) {
    kept.set({ task: mode });
  },
};

/** @type {Record<Mode, string>} */
const SAYS = {
  heal: "Brush over what must go. Everything else stays, byte for byte.",
  extend: "Drag the frame outwards. The picture stays, and grows beyond its borders.",
  tile: "The picture will continue in itself. A wall is first cut to whole rows of stones; then only a band along its borders changes.",
};

export class MendRoom extends Living {
  stage = new Stage();
  panel = el("aside", { class: "panel", "aria-label": "Mending" });
  named = el("h2", { class: "one-line" });
  go = button("", () => void this.mend(), { class: "strong big" });
  margins = new Margins(this.stage, settings.extend.past, () => this.#framed());
  hint = el("span", { class: "corner low left" }, "Drag the frame outwards");
  /** @type {import("../stage/stage.js").Layer | null} what the hole would be enlarged by */
  #ring = null;
  rim = new Rim(settings.heal, () => this.#hole(), (ring) => [(this.#ring = ring), this.#lay()]);
  /** @type {Map<import("../stage/margins.js").Side, HTMLInputElement>} */ #fields = new Map();

  /** What the last change of the chosen task is remembered in. */
  get past() {
    return settings[task.mode].past;
  }

  connectedCallback() {
    this.className = "paint";
    this.stage.append(this.hint);
    const { signal } = this.gone;
    const head = el("div", { class: "head" }, this.named, viewButtons(this.stage, false));
    const half = el("section", { class: "half", "aria-label": "Picture" }, head, this.stage);
    const { main, buttons, onward } = beside(half, this.go, "Back to the picture", Object.values(settings).map((each) => each.past), signal);
    this.buttons = buttons;
    this.onward = onward;
    fill(this, main, this.panel);
    this.brush = new Brush(this.stage, kit, () => (task.mode === "heal" ? this.#hole() : null));
    kit.set({ value: 1 });
    toolKeys(kit, signal, 0);
    store.on(["exemplar"], () => void this.#show(), signal);
    kit.history.addEventListener("change", () => this.#keep(), { signal });
    for (const each of [kit.history, settings.heal]) each.addEventListener("change", () => void this.rim.look(), { signal });
    this.#mode();
  }

  /** @returns {import("../paint/labels.js").Labels | null} */
  #hole() {
    return labelsOf(holes, "hole", () => [this.stage.draw(), void this.rim.look()]);
  }

  /** Keep what was just painted. */
  #keep() {
    const hole = this.#hole();
    if (store.exemplar && hole) void keep(store.exemplar.id, "hole", hole);
  }

  async #show() {
    const exemplar = store.exemplar;
    if (!exemplar) return;
    await tried(async () => {
      const picture = await store.picture(viewOf(exemplar));
      if (store.exemplar?.id !== exemplar.id) return;
      this.named.textContent = exemplar.name;
      this.margins.own = exemplar.id;
      this.margins.px = { left: 0, right: 0, top: 0, bottom: 0, ...kept.of(exemplar.id).margins };
      this.stage.show(picture, `Picture ${exemplar.name}`, [exemplar.width, exemplar.height], viewOf(exemplar));
      this.#mode();
    });
  }

  /** Take the tools of the chosen task. */
  #mode() {
    const { mode } = task;
    this.#ring = null;
    this.#lay();
    void this.rim.look();
    this.stage.around = mode === "extend" ? this.margins.around : 0;
    if (this.brush) {
      this.stage.tool = mode === "heal" ? this.brush : mode === "extend" ? this.margins : null;
      this.stage.marks = mode === "heal" ? (pen, view) => this.brush?.ring(pen, view) : null;
      if (mode === "extend") this.stage.marks = (pen, view) => this.margins.marks(pen, view);
    }
    this.stage.classList.toggle("drawing", mode === "heal");
    this.stage.fit();
    this.#panel();
  }

  /** Lay the hole over the picture while it is healed, and its rim. */
  #lay() {
    const hole = task.mode === "heal" ? this.#hole() : null;
    this.stage.layers = hole ? [{ picture: hole.canvas, alpha: 0.75 }, this.#ring].filter(there) : [];
    this.stage.draw();
  }

  #panel() {
    const { mode } = task;
    /** @type {[Mode, string][]} */ const modes = [["heal", "Heal"], ["extend", "Extend"], ["tile", "Tile"]];
    const choice = segments("Task", modes, () => task.mode, (next) => [(task.mode = next), void this.onward?.(), this.#mode()], { wide: true });
    const quarter = button("25 % all around", () => {
      const [x = 0, y = 0] = [this.stage.size.width, this.stage.size.height].map((side) => Math.round(side / 4));
      this.margins.set({ left: x, right: x, top: y, bottom: y });
    }, { class: "framed" });
    this.go.textContent = { heal: "Heal", extend: "Extend", tile: "Make it tile" }[mode];
    const fields = el("div", { class: "fields" }, choice.element, el("p", { class: "quiet" }, SAYS[mode]));
    if (mode === "heal") fields.append(toolbar(kit), this.rim.element);
    else fields.append(el("div", { class: "headed" }, mode === "extend" ? quarter : el("span"), el("span", {}, undoButtons(this.past))));
    if (mode !== "heal") fields.append(mode === "extend" ? this.#sides() : this.#axes());
    fields.append(seedField(settings[mode]), methodPicker(settings[mode], choicesOf(mode, "method")));
    fill(this.panel, this.buttons, fields);
    this.#told();
  }

  #sides() {
    const names = /** @type {import("../stage/margins.js").Side[]} */ (["left", "right", "top", "bottom"]);
    const rows = names.map((side) => {
      const id = `margin-${side}`;
      const input = el("input", {
        class: "field", type: "number", id, min: "0", max: "8192", step: "1",
        oninput: () => this.margins.set({ ...this.margins.px, [side]: Math.max(0, Math.min(8192, Math.round(Number(input.value) || 0))) }, side),
      });
      this.#fields.set(side, input);
      return el("div", { class: "row" }, el("label", { for: id }, side.charAt(0).toUpperCase() + side.slice(1)), input);
    });
    return el("div", { class: "group" }, rows);
  }

  #axes() {
    const own = settings.tile;
    /** @type {[string, string][]} */ const choices = [["x", "Across"], ["y", "Down"], ["both", "Both"]];
    const axes = segments("Axes", choices, () => own.options.axes ?? "both", (axis) => own.set("axes", axis === "both" ? null : axis), { wide: true });
    follow(own, axes.element, axes.show);
    return el("div", { class: "row" }, el("span", {}, "Axes"), axes.element);
  }

  /** The frame is another one: keep it, and show all of it, unless it is being dragged. */
  #framed() {
    kept.set({ margins: this.margins.px }, this.margins.own);
    this.stage.around = this.margins.around;
    if (this.margins.held.length || !this.stage.view.fitted) this.stage.draw();
    else this.stage.fit();
    this.#told();
  }

  /** Write the margins into their fields. */
  #told() {
    this.hint.hidden = task.mode !== "extend" || !this.margins.none;
    for (const [side, input] of this.#fields) {
      if (document.activeElement !== input) input.value = String(this.margins.px[side]);
    }
  }

  /** Do what is chosen. */
  async mend() {
    const exemplar = store.exemplar;
    if (!exemplar || refused(this.panel)) return;
    const { mode } = task;
    /** @type {Record<string, any>} */ const options = { ...settings[mode].options };
    if (options.seed && mode !== "extend" && !options.method) options.tolerance = ANOTHER;
    await tried(async () => {
      const hole = this.#hole();
      if (mode === "heal") {
        if (!hole?.data.some((value) => value > 0)) return complain("Brush over what must go first.");
        options.mask = [await send(hole, (value) => (value ? 255 : 0))];
      } else if (mode === "extend") {
        const wider = Object.entries(this.margins.px).filter(([, px]) => px > 0);
        if (!wider.length) return complain("Drag a side of the frame outwards first.");
        Object.assign(options, Object.fromEntries(wider));
      }
      store.look((await store.start(mode, [exemplar.id], options)).id);
    });
  }
}

customElements.define("mend-room", MendRoom);
