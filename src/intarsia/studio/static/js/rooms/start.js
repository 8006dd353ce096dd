/** Where everything begins: a place to drop a picture on, what was opened before, and the built-in samples. */

import { button, el, fill, Living } from "../core/dom.js";
import { viewOf } from "../core/api.js";
import { icon } from "../core/icons.js";
import { store } from "../core/store.js";
import { bringSample, pick } from "../parts/bring.js";
import { diskUse } from "../parts/names.js";
import { takeAway } from "../parts/taking.js";

export class StartRoom extends Living {
  refused = el("p", { class: "refused bad", role: "alert" });
  disk = diskUse();

  connectedCallback() {
    this.className = "start";
    addEventListener("refused", (e) => {
      e.preventDefault();
      this.refused.textContent = /** @type {CustomEvent} */ (e).detail;
    }, { signal: this.gone.signal });
    store.on(["exemplars"], () => this.#draw(), this.gone.signal);
  }

  #draw() {
    const drop = el(
      "section",
      { class: "drop", "aria-label": "Open a picture" },
      el("h1", {}, "Drop a picture of a texture"),
      el("p", { class: "quiet" }, "or paste one. All maps of a material at once make one example."),
      this.refused,
      button("Choose files", pick, { class: "strong big" }),
    );
    const before = store.exemplars.map((exemplar) =>
      card(exemplar.name, viewOf(exemplar, 320), () => {
        store.choose(exemplar);
        location.hash = "#grow";
      }, exemplar.id),
    );
    const samples = (store.schema?.samples ?? []).map((name) =>
      card(name, `/api/samples/${name}.png?side=320`, () => void bringSample(name)),
    );
    fill(
      this,
      drop,
      before.length > 0 && el("section", { "aria-label": "Opened before" }, el("div", { class: "headed" }, el("h2", {}, "Opened before"), this.disk), el("ul", { class: "cards" }, before)),
      el("section", { "aria-label": "Built-in samples" }, el("h2", {}, "Built-in samples"), el("ul", { class: "cards" }, samples)),
    );
  }
}

/** @param {string} name @param {string} src @param {() => void} act
 * @param {string} [id] of an exemplar that can be taken away */
function card(name, src, act, id) {
  const picture = el("img", { src, alt: "", loading: "lazy", decoding: "async" });
  const away = id && button(`Delete ${name}`, () => void takeAway("exemplars", id), { icon: icon("bin"), bare: true, class: "away" });
  return el("li", {}, el("button", { type: "button", class: "card", onclick: act }, picture, el("span", { class: "one-line", title: name }, name)), away);
}

customElements.define("start-room", StartRoom);
