/** Where everything begins: a place to drop a picture on, what was opened before, and the built-in samples. */

import { button, el, fill } from "../core/dom.js";
import { viewOf } from "../core/api.js";
import { icon } from "../core/icons.js";
import { store } from "../core/store.js";
import { bringSample, pick } from "../parts/bring.js";
import { takeAway } from "../parts/taking.js";

export class StartRoom extends HTMLElement {
  #gone = new AbortController();

  connectedCallback() {
    this.className = "start";
    store.on(["exemplars"], () => this.#draw(), this.#gone.signal);
  }

  disconnectedCallback() {
    this.#gone.abort();
  }

  #draw() {
    const drop = el(
      "section",
      { class: "drop", "aria-label": "Open a picture" },
      el("h1", {}, "Drop a picture of a texture"),
      el("p", { class: "quiet" }, "or paste one. All maps of a material at once make one example."),
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
      before.length > 0 && el("section", { "aria-label": "Opened before" }, el("h2", {}, "Opened before"), el("ul", { class: "cards" }, before)),
      el("section", { "aria-label": "Built-in samples" }, el("h2", {}, "Built-in samples"), el("ul", { class: "cards" }, samples)),
    );
  }
}

/**
 * @param {string} name
 * @param {string} src
 * @param {() => void} act
 * @param {string} [id] of an exemplar that can be taken away
 */
function card(name, src, act, id) {
  const picture = el("img", { src, alt: "", loading: "lazy", decoding: "async" });
  const away = id && button(`Delete ${name}`, () => void takeAway("exemplars", id), { icon: icon("bin"), bare: true, class: "away" });
  return el("li", {}, el("button", { type: "button", class: "card", onclick: act }, picture, el("span", { class: "one-line", title: name }, name)), away);
}

customElements.define("start-room", StartRoom);
