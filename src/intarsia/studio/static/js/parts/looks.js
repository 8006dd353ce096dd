/** How what is on the stage is looked at: a plane as it is, lit, or with pieces, seams, use or sources laid over it. */

import { lookOf } from "../core/api.js";
import { el, fill } from "../core/dom.js";
import { store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { readable } from "../core/words.js";
import { canBeLit, Lit } from "../lit/lit.js";
import { segments } from "./choice.js";

/**
 * What is looked at; `result`: whose map says where its pixels come from; `judged`: whether it is that result itself.
 * @typedef {import("../lit/lit.js").Subject & {result: string | null, judged?: boolean}} Subject
 */
/** @typedef {"" | "lit" | "pieces" | "seams" | "usage" | "provenance"} Look */

/** @type {{look: Look, says: string, alpha: number, told: string}[]} */
const LOOKS = [
  { look: "", says: "Picture", alpha: 1, told: "" },
  { look: "lit", says: "Lit", alpha: 1, told: "" },
  { look: "pieces", says: "Pieces", alpha: 0.72, told: "Each colour is one piece, copied whole" },
  { look: "seams", says: "Seams", alpha: 1, told: "The redder, the more a seam shows" },
  { look: "usage", says: "How often", alpha: 0.85, told: "The brighter, the more often its place is shown" },
  { look: "provenance", says: "Where from", alpha: 0.85, told: "Each colour is a place of the example" },
];

/** Whether something can be looked at like this.
 * @param {Subject | null} subject @param {Look} look */
function has(subject, look) {
  if (!look) return true;
  if (look === "lit") return canBeLit(subject?.planes ?? []);
  return Boolean(subject?.result && (subject.judged || look !== "seams"));
}

const DARK = "This browser has no WebGL 2, which light needs.";

export class Looks {
  element = el("span", { class: "looks", hidden: true });
  legend = el("span", { class: "corner low left", role: "status" });
  /** What of a material is seen. */
  planes = el("select", { class: "field planes-field", "aria-label": "Map", hidden: true, onchange: () => this.other((this.plane = this.planes.value)) });
  /** @type {Look} the one that was chosen; it comes again with the next result that has it */
  wanted = "";
  /** @type {string | null} the plane that is looked at */
  plane = null;
  /** @type {Subject | null} */ #subject = null;
  #offered = "";
  #turn = 0;

  /** @param {import("../stage/stage.js").Stage} stage
   * @param {(plane: string) => void} other another plane is asked for */
  constructor(stage, other) {
    this.stage = stage;
    this.other = other;
    this.lit = new Lit(stage);
  }

  /** Which subject is looked at. */
  get of() {
    return this.#subject?.id ?? null;
  }

  /** The plane of these that is shown: the one that was chosen, or the first.
   * @param {string[]} planes */
  chosen(planes) {
    return planes.find((each) => each === this.plane) ?? planes[0] ?? "albedo";
  }

  /** @param {Subject | null} subject that is on the stage */
  show(subject) {
    this.#subject = subject;
    const planes = subject?.planes ?? [];
    const looks = LOOKS.filter(({ look }) => has(subject, look));
    this.element.hidden = looks.length < 2;
    if (subject) this.plane = this.chosen(planes);
    const offered = `${looks.map(({ look }) => look)} ${planes} ${this.plane}`;
    if (offered !== this.#offered) this.#offer(looks, planes);
    this.#offered = offered;
    void this.#lay();
  }

  /** Nothing is laid over any more: two are compared. */
  plain() {
    this.wanted = "";
    this.#offered = "";
    this.show(this.#subject);
  }

  /** @param {typeof LOOKS} looks @param {string[]} planes */
  #offer(looks, planes) {
    const choice = segments(
      "Look at",
      looks.map(({ look, says }) => [look, says]),
      () => (looks.some(({ look }) => look === this.wanted) ? this.wanted : ""),
      (look) => {
        this.wanted = look;
        void this.#lay();
      },
    );
    fill(this.element, looks.length > 1 && choice.element);
    fill(this.planes, planes.map((plane) => el("option", { value: plane, selected: plane === this.plane }, readable(plane))));
  }

  async #lay() {
    const turn = ++this.#turn;
    const still = () => turn === this.#turn;
    const subject = this.#subject;
    const chosen = LOOKS.find(({ look }) => look === this.wanted && has(subject, look));
    this.stage.layers = [];
    this.planes.hidden = (subject?.planes.length ?? 0) < 2 || chosen?.look === "lit";
    if (!subject || chosen?.look !== "lit") this.lit.hide();
    this.stage.draw();
    if (!subject || !chosen?.look) {
      this.legend.textContent = "";
      return;
    }
    this.legend.textContent = "…";
    let told = "";
    await tried(async () => {
      if (chosen.look === "lit") {
        told = (await this.lit.show(subject, still)) ? "" : DARK;
        return;
      }
      if (!subject.result) return;
      const picture = await store.picture(lookOf(subject.result, chosen.look));
      if (!still()) return;
      this.stage.layers = [{ picture, alpha: chosen.alpha }];
      this.stage.draw();
      told = chosen.told;
    });
    if (still()) this.legend.textContent = told;
  }
}
