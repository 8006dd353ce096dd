/** Endless: a texture without borders, walked over for ever. */

import { post, Refused, viewOf } from "../core/api.js";
import { button, el, fill, follow, Living } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { Settings } from "../core/settings.js";
import { store } from "../core/store.js";
import { complain, copied, say, tried } from "../core/toast.js";
import { FarView, Sight } from "../endless/sight.js";
import { Tiles } from "../endless/tiles.js";
import { methodPicker, parameterForm } from "../parts/methods.js";
import { choicesOf } from "../parts/options.js";
import { needing } from "../parts/result-actions.js";
import { seedField } from "../parts/seed.js";
import { undoButtons } from "../parts/undo.js";

const settings = new Settings("endless");
const view = new FarView();

export class EndlessRoom extends Living {
  past = settings.past;
  tiles = new Tiles();
  sight = new Sight(this.tiles, view);
  panel = el("aside", { class: "panel", "aria-label": "Endless" });
  status = el("span", { class: "corner low left later", role: "status", hidden: true });
  place = el("span", { class: "endless-place quiet small number" });
  /** What the server knows it by; "" while it is none. */
  weave = "";
  /** @type {Promise<void>} until the server knows what is wanted now */
  begun = Promise.resolve();
  #sent = "";
  /** @type {string} the exemplar whose texture it is */
  #of = "";
  /** Whether the server is being told what is wanted. */
  busy = false;

  connectedCallback() {
    this.className = "paint";
    const { signal } = this.gone;
    const buttons = el(
      "div",
      { class: "view-buttons" },
      this.place,
      el("div", { class: "segments" }, button("Start", () => this.sight.fit(), { title: "Where it begins (0)" }), button("100 %", () => this.sight.whole(), { title: "Pixel for pixel (1)" })),
    );
    this.sight.append(this.status);
    fill(this, el("section", { class: "half", "aria-label": "Endless texture" }, el("div", { class: "head" }, el("h2", {}, "Endless"), buttons), this.sight), this.panel);
    this.sight.addEventListener("view", () => this.#place(), { signal });
    this.sight.addEventListener("drawn", () => this.#say(), { signal });
    this.tiles.addEventListener("lost", () => this.#lost(), { signal });
    this.tiles.addEventListener("refused", (e) => complain(/** @type {CustomEvent} */ (e).detail), { signal });
    follow(settings, this, () => void this.#begin());
    store.on(["exemplar"], () => this.#turn(), signal);
  }

  /** Another exemplar is looked at. */
  #turn() {
    const { exemplar } = store;
    if (!exemplar) return;
    this.sight.call(`Endless texture of ${exemplar.name}`);
    if (this.#of !== exemplar.id) void tried(() => this.#ground(exemplar));
    this.#of = exemplar.id;
    const command = button("Command", () => void this.command(), { icon: icon("copy"), bare: true, title: "Copy the command that makes this view" });
    fill(
      this.panel,
      el("div", { class: "do" }, button("Keep this view", () => void this.keep(), { class: "strong big" }), command, el("span", {}, undoButtons(settings.past))),
      el("div", { class: "fields" }, seedField(settings), methodPicker(settings, choicesOf("weave", "method")), parameterForm(settings)),
    );
    this.#place();
    void this.#begin();
  }

  /** Show the example until something of its texture is there; of another one's nothing stays.
   * @param {import("../core/types.js").Exemplar} exemplar */
  async #ground(exemplar) {
    this.tiles.turn("");
    this.tiles.forget();
    const picture = await store.picture(viewOf(exemplar, 512));
    if (store.exemplar?.id === exemplar.id) this.sight.ground = { picture, width: exemplar.width };
    this.sight.draw();
  }

  /** Say what goes on, where something does. */
  #say() {
    const says = this.busy ? "Looking at the example" : this.weave && this.tiles.missing ? "Drawing what is in sight" : "";
    if (this.status.textContent !== says) this.status.textContent = says;
    this.status.hidden = !says;
  }

  #place() {
    const { x, y, width, height } = this.sight.window;
    const [u, v] = [Math.round(x + width / 2), Math.round(y + height / 2)];
    this.place.textContent = `x ${u}   y ${v}   ${Math.round(view.scale * 100)} %`;
  }

  /** What is wanted now, as the server is asked for it. */
  #wanted() {
    return { exemplar: store.exemplar?.id, options: settings.options };
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
        this.#say();
        await this.#show(next);
      }
    } finally {
      this.busy = false;
      this.#say();
    }
  }

  /** @param {object} wanted */
  async #show(wanted) {
    this.weave = "";
    try {
      this.weave = (await post("/api/weaves", wanted)).id;
    } catch (error) {
      if (error instanceof Refused && error.status === 0) this.#sent = "";
      complain(error);
    }
    this.tiles.turn(this.weave);
    this.sight.draw();
  }

  /** The server began anew meanwhile, and knows nothing of this. */
  #lost() {
    this.#sent = "";
    void this.#begin();
  }

  /** @returns {Promise<{job: import("../core/types.js").Job, command: string, needs: string[]} | null>} what makes the window in sight */
  async #window() {
    await this.#begin();
    const { x, y, width, height } = this.sight.window;
    return this.weave ? post(`/api/weaves/${this.weave}/window`, { size: `${width}x${height}`, origin: `${x},${y}` }) : null;
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
