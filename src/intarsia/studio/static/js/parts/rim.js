/** How far a hole is enlarged before it is healed: as it was painted, or as far as a rim of the defect is seen, which is drawn. */

import { rimOf } from "../core/api.js";
import { el, follow } from "../core/dom.js";
import { store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { send } from "../paint/send.js";
import { segments } from "./choice.js";

const MOMENT = 250;

export class Rim {
  said = el("p", { class: "quiet small number", role: "status" });
  #turn = 0;

  /** @param {import("../core/settings.js").Settings} settings of healing @param {() => import("../paint/labels.js").Labels | null} hole
   * @param {(rim: import("../stage/stage.js").Layer | null) => void} show */
  constructor(settings, hole, show) {
    this.settings = settings;
    this.hole = hole;
    this.show = show;
    const choice = segments("Rim", [["", "As painted"], ["auto", "With rim"]], () => (this.auto ? "auto" : ""), (grow) => settings.set("grow", grow || null), { wide: true });
    this.element = el("div", { class: "group" }, el("div", { class: "row" }, el("span", {}, "Hole"), choice.element), this.said);
    follow(settings, choice.element, choice.show);
  }

  get auto() {
    return this.settings.options.grow === "auto";
  }

  /** Look again: the hole, or what is wanted, has changed. */
  async look() {
    const turn = ++this.#turn;
    const hole = this.hole();
    this.show(null);
    this.said.textContent = "";
    const exemplar = store.exemplar;
    if (!this.auto || !exemplar || !hole?.data.some((value) => value > 0)) return;
    await new Promise((done) => setTimeout(done, MOMENT));
    if (turn !== this.#turn) return;
    this.said.textContent = "Looking for a rim …";
    await tried(async () => {
      const image = await send(hole, (value) => (value ? 255 : 0));
      const { grow, drawn } = await rimOf(exemplar, image);
      if (turn !== this.#turn) return;
      this.said.textContent = grow ? `The rim is ${grow} px wide.` : "No rim is seen.";
      this.show({ picture: drawn, alpha: 0.75 });
    });
    if (turn === this.#turn && this.said.textContent?.endsWith("…")) this.said.textContent = "";
  }
}
