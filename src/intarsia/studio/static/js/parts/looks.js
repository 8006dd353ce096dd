/** What is laid over a result: the pieces it is made of, seams, how often places are used, where they come from, damage. */

import { lookOf } from "../core/api.js";
import { el, fill } from "../core/dom.js";
import { store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { readable } from "../core/words.js";
import { segments } from "./choice.js";

/** @typedef {import("../core/types.js").Result} Result */
/** @typedef {"" | "pieces" | "seams" | "usage" | "provenance" | "damaged"} Look */

/** @type {{look: Look, says: string, alpha: number, told: string}[]} */
const LOOKS = [
  { look: "", says: "Picture", alpha: 1, told: "" },
  { look: "pieces", says: "Pieces", alpha: 0.72, told: "Each colour is one piece, copied whole" },
  { look: "seams", says: "Seams", alpha: 1, told: "The redder, the more a join costs" },
  { look: "usage", says: "Usage", alpha: 0.85, told: "The brighter, the more often its place is shown" },
  { look: "provenance", says: "Source", alpha: 0.85, told: "Red from the right of the exemplar, green from below" },
  { look: "damaged", says: "Damage", alpha: 1, told: "Outlines: elements that are like none of the exemplar" },
];

export class Looks {
  element = el("span", { class: "looks", hidden: true });
  legend = el("span", { class: "corner low left", role: "status" });
  /** @type {Look} */
  look = "";
  /** @type {string | null} the plane that is looked at */
  plane = null;
  /** @type {Result | null} */
  #result = null;
  #turn = 0;

  /**
   * @param {import("../stage/stage.js").Stage} stage
   * @param {(plane: string) => void} other another plane is asked for
   */
  constructor(stage, other) {
    this.stage = stage;
    this.other = other;
    this.choice = segments(
      "Look at",
      LOOKS.map(({ look, says }) => [look, says]),
      () => this.look,
      (look) => {
        this.look = look;
        void this.#lay();
      },
    );
  }

  /**
   * @param {Result | null} result that is on the stage
   * @param {string[]} planes of it
   */
  show(result, planes) {
    this.#result = result;
    this.element.hidden = !result;
    if (!planes.includes(this.plane ?? "")) this.plane = planes[0] ?? null;
    const list = el(
      "select",
      { class: "field", "aria-label": "Plane", onchange: () => this.other((this.plane = list.value)) },
      planes.map((plane) => el("option", { value: plane, selected: plane === this.plane }, readable(plane))),
    );
    fill(this.element, this.choice.element, planes.length > 1 && list);
    void this.#lay();
  }

  async #lay() {
    const turn = ++this.#turn;
    const chosen = LOOKS.find((each) => each.look === this.look);
    const result = this.#result;
    this.stage.layers = [];
    this.stage.draw();
    if (!result || !chosen?.look) {
      this.legend.textContent = "";
      return;
    }
    this.legend.textContent = "…";
    await tried(async () => {
      const picture = await store.picture(lookOf(result.id, chosen.look));
      if (turn !== this.#turn) return;
      this.stage.layers = [{ picture, alpha: chosen.alpha }];
      this.stage.draw();
    });
    if (turn === this.#turn) this.legend.textContent = this.stage.layers.length ? chosen.told : "";
  }
}
