/** Endless: a texture without borders, walked over for ever; a brush that says where it is jittered less, and where more. */

import { post, Refused } from "../core/api.js";
import { button, el, fill, follow } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { Settings } from "../core/settings.js";
import { store } from "../core/store.js";
import { complain, copied, say, tried } from "../core/toast.js";
import { JitterBrush } from "../endless/brush.js";
import { brushFields } from "../endless/painting.js";
import { FarView, Sight } from "../endless/sight.js";
import { Strokes } from "../endless/strokes.js";
import { Tiles } from "../endless/tiles.js";
import { toolKeys } from "../paint/tools.js";
import { methodPicker, parameterForm, take } from "../parts/methods.js";
import { choicesOf } from "../parts/options.js";
import { needing } from "../parts/result-actions.js";
import { seedField } from "../parts/seed.js";

/** @typedef {{id: string, method: string, brush: boolean, levels: number}} Weave */

const BRUSHED = "jitter_output";
const settings = new Settings("endless");
const strokes = new Strokes();
const view = new FarView();

export class EndlessRoom extends HTMLElement {
  tiles = new Tiles();
  sight = new Sight(this.tiles, view);
  panel = el("aside", { class: "panel", "aria-label": "Endless" });
  status = el("span", { class: "corner low left", role: "status" });
  place = el("span", { class: "endless-place quiet small number" });
  brush = el("div", { class: "group" });
  /** @type {Weave | null} what is shown */
  weave = null;
  /** @type {Promise<void>} until the server knows what is wanted now */
  begun = Promise.resolve();
  #gone = new AbortController();
  #sent = "";
  #texture = "";
  /** Whether the server is being told what is wanted. */
  busy = false;

  connectedCallback() {
    this.className = "paint";
    const { signal } = this.#gone;
    const buttons = el(
      "div",
      { class: "view-buttons" },
      this.place,
      el("div", { class: "segments" }, button("Middle", () => this.sight.home(), { title: "Where it begins (0)" }), button("100 %", () => this.sight.whole(), { title: "Pixel for pixel (1)" })),
    );
    this.sight.append(this.status);
    fill(this, el("section", { class: "half", "aria-label": "Endless texture" }, el("div", { class: "head" }, el("h2", {}, "Endless"), buttons), this.sight), this.panel);
    this.jitter = new JitterBrush(this.sight, strokes, () => this.#able());
    this.sight.addEventListener("view", () => this.#place(), { signal });
    this.tiles.addEventListener("lost", () => this.#lost(), { signal });
    this.tiles.addEventListener("refused", (e) => complain(/** @type {CustomEvent} */ (e).detail), { signal });
    toolKeys(strokes, signal, 0);
    for (const each of [settings, strokes]) follow(each, this, () => void this.#begin());
    store.on(["exemplar"], () => this.#turn(), signal);
  }

  disconnectedCallback() {
    this.#gone.abort();
  }

  /** Another exemplar is looked at. */
  #turn() {
    if (!store.exemplar) return;
    this.sight.call(`Endless texture of ${store.exemplar.name}`);
    strokes.turn(store.exemplar.id);
    const command = button("Command", () => void this.command(), { icon: icon("copy"), bare: true, title: "Copy the command that makes this view" });
    fill(
      this.panel,
      el("div", { class: "do" }, button("Keep this view", () => void this.keep(), { class: "strong big" }), command),
      el("div", { class: "fields" }, seedField(settings), methodPicker(settings, choicesOf("weave", "method")), parameterForm(settings), el("h3", {}, "Brush of jitter"), this.brush),
    );
    this.#place();
    void this.#begin();
  }

  #place() {
    const { x, y, width, height } = this.sight.window;
    const [u, v] = [Math.round(x + width / 2), Math.round(y + height / 2)];
    this.place.textContent = `x ${u}   y ${v}   ${Math.round(view.scale * 100)} %`;
  }

  /** What is wanted now, as the server is asked for it. */
  #wanted() {
    const { method = "auto", seed = 0, ...options } = settings.options;
    return { exemplar: store.exemplar?.id, method, seed, options, ...(strokes.jitter ? { jitter: strokes.jitter } : {}) };
  }

  /** Have the server know what is wanted; what changes meanwhile is told afterwards, once. */
  #begin() {
    if (!this.busy && store.exemplar) this.begun = this.#tell();
    return this.begun;
  }

  async #tell() {
    this.busy = true;
    try {
      for (let next = this.#wanted(); JSON.stringify(next) !== this.#sent; next = this.#wanted()) {
        this.#sent = JSON.stringify(next);
        const texture = JSON.stringify({ ...next, jitter: null });
        if (texture !== this.#texture) this.status.textContent = "Looking at the exemplar";
        await this.#show(next, texture);
      }
    } finally {
      this.busy = false;
      this.status.textContent = "";
    }
  }

  /**
   * @param {object} wanted
   * @param {string} texture what of it makes another texture
   */
  async #show(wanted, texture) {
    try {
      this.weave = await post("/api/weaves", wanted);
    } catch (error) {
      if (error instanceof Refused && error.status === 0) this.#sent = "";
      this.weave = null;
      complain(error);
    }
    if (this.weave) view.levels = this.weave.levels;
    this.tiles.turn(this.weave?.id ?? "", texture !== this.#texture || !this.weave);
    this.#texture = texture;
    this.sight.draw();
    this.#brushes();
  }

  /** The server began anew meanwhile, and knows nothing of this. */
  #lost() {
    this.#sent = "";
    void this.#begin();
  }

  /** Whether there is a brush now. What was chosen by itself is chosen for good once it is painted on. */
  #able() {
    if (!this.weave?.brush) return false;
    if (!settings.options.method) take(settings, this.weave.method);
    return true;
  }

  #brushes() {
    const able = this.weave?.brush ?? false;
    if (this.brush.dataset.able === String(able)) return;
    this.brush.dataset.able = String(able);
    if (!able && strokes.tool !== "move") strokes.set({ tool: "move" });
    const windows = choicesOf("weave", "method");
    const other = store.schema?.methods.find((m) => windows.includes(m.slug) && m.parameters.some((p) => p.name === BRUSHED));
    if (able) fill(this.brush, brushFields(strokes));
    else if (other) fill(this.brush, el("p", { class: "quiet" }, "This method has no jitter to paint."), button(`Take ${other.slug}`, () => take(settings, other.slug), { class: "framed" }));
  }

  /** @returns {Promise<{job: import("../core/types.js").Job, command: string, needs: string[]} | null>} what makes the window in sight */
  async #window() {
    await this.#begin();
    return this.weave && post(`/api/weaves/${this.weave.id}/window`, this.sight.window);
  }

  async command() {
    const found = await tried(() => this.#window());
    if (found) await copied(found.command, `Command copied${needing(found.needs, "the zip of what Keep this view makes")}`);
  }

  /** Make what is in sight a result. */
  async keep() {
    await tried(async () => {
      const found = await this.#window();
      if (!found) return;
      await store.start(found.job.verb, found.job.exemplars, found.job.options);
      say("This view is being made; it will be in the gallery");
    });
  }
}

customElements.define("endless-room", EndlessRoom);
