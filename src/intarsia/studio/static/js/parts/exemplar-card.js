/** The exemplar that is worked with: its picture, its size, its planes; and the others that are open. */

import { button, el, fill, Living } from "../core/dom.js";
import { viewOf } from "../core/api.js";
import { icon } from "../core/icons.js";
import { store } from "../core/store.js";
import { facts, readable, size } from "../core/words.js";
import { imageOf } from "../paint/marks.js";
import { pick } from "./bring.js";
import { forEngine, proposing } from "./material.js";
import { heading } from "./names.js";
import { drawSteps } from "./steps.js";

class ExemplarCard extends Living {
  mark = el("span", { class: "source-mark", hidden: true });
  steps = el("nav", { "aria-label": "Steps", hidden: true });

  connectedCallback() {
    this.className = "exemplar-card";
    store.on(["exemplar", "exemplars"], () => this.#draw(), this.gone.signal);
    store.on(["source"], () => this.#point(), this.gone.signal);
    store.on(["exemplar", "exemplars", "jobs", "chosen"], () => drawSteps(this.steps), this.gone.signal);
  }

  /** Mark the pixel that the one under the pointer came from. */
  #point() {
    const { source, exemplar } = store;
    this.mark.hidden = !source;
    if (!source || !exemplar) return;
    this.mark.style.left = `${((source.x + 0.5) / exemplar.width) * 100}%`;
    this.mark.style.top = `${((source.y + 0.5) / exemplar.height) * 100}%`;
  }

  #draw() {
    const exemplar = store.exemplar;
    if (!exemplar) return fill(this);
    const { name, width, height, planes } = exemplar;
    const picture = el("img", { class: "main", src: viewOf(exemplar, 480), alt: `Example ${name}`, width, height });
    const others = store.exemplars.filter((other) => other.id !== exemplar.id);
    fill(
      this,
      el("button", { type: "button", class: "see", title: "See the example", onclick: () => store.look(null) }, picture, this.mark),
      el("div", {}, heading("exemplars", exemplar, "h2"), el("p", { class: "quiet small number" }, facts(size(width, height), `${exemplar.depth} bit`))),
      imageOf(exemplar.id, "avoid") && el("p", { class: "quiet small" }, "Parts are marked as avoided."),
      planes.length > 1 && el("ul", { class: "planes" }, planes.map((plane) => el("li", {}, readable(plane.name), plane.proposed && " (proposed)"))),
      proposing(planes.map((plane) => plane.name)),
      planes.length > 1 && forEngine("the example", `/api/exemplars/${exemplar.id}`, planes.map((plane) => plane.name)),
      this.steps,
      el(
        "div",
        { class: "others" },
        others.map((other) => {
          const small = el("img", { src: viewOf(other, 128), alt: "" });
          return el("button", {
            type: "button", class: "thumb", title: other.name, "aria-label": `Use ${other.name}`,
            onclick: () => store.choose(other),
          }, small);
        }),
        button("Open another", pick, { icon: icon("add"), bare: true, class: "framed thumb" }),
      ),
    );
  }
}

customElements.define("exemplar-card", ExemplarCard);
export { ExemplarCard };
