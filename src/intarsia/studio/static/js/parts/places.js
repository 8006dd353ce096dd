/** Places where a result is not good, marked on the stage by numbers: one is gone to, and repaired. */

import { button, el, fill } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { exemplarOf, store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { Labels } from "../paint/labels.js";
import { send } from "../paint/send.js";

/** @typedef {import("../core/types.js").Job} Job */
/** @typedef {[number, number, number]} Spot a square: its left and upper border and its side, px of the result */
/** @typedef {{job: Job, result: import("../core/types.js").Result, part: string, spots: Spot[]}} Marked */

/** Radius of what is made anew, and of what is not taken in its place, in sides. */
const [ANEW, SAME] = [1.2, 0.8];

/** Options of growing after which the example is not what was grown from. */
const CHANGED = ["mask", "crop", "flatten", "scale", "avoid"];

export class Places {
  bar = el("div", { class: "places", role: "group", "aria-label": "Marked places", hidden: true, onpointerdown: (/** @type {Event} */ e) => e.stopPropagation() });
  repair = button("Repair here", () => void tried(() => this.#repair()), { class: "strong", title: "Make this place anew, as a step of its own" });
  /** @type {Marked | null} */ #marked = null;
  #at = -1;
  /** @type {{id: string, part: string, spots: Spot[]} | null} what is left once the job of a repair is done */
  #left = null;

  /** @param {import("../stage/stage.js").Stage} stage */
  constructor(stage) {
    this.stage = stage;
    stage.append(this.bar);
  }

  /** @param {Marked | null} marked null: no places any more @param {string} [says] */
  show(marked, says = "") {
    [this.#marked, this.#at] = [marked, -1];
    this.bar.hidden = !marked;
    this.stage.marks = marked && ((pen, view) => this.#draw(pen, view));
    this.stage.tool = marked && { down: (x, y) => this.#go(marked.spots.findIndex(([u, v, side]) => x >= u && y >= v && x < u + side && y < v + side)), move() {}, up() {}, stop() {} };
    this.stage.draw();
    this.repair.disabled = true;
    const numbers = (marked?.spots ?? []).map((_, n) => button(String(n + 1), () => this.#go(n), { "aria-label": `Place ${n + 1}`, "aria-pressed": "false" }));
    const away = button("Hide the marks", () => this.show(null), { icon: icon("close"), bare: true });
    fill(this.bar, el("span", { role: "status", title: says }, says), el("span", { class: "segments" }, numbers), this.repair, away);
    numbers[0]?.focus({ preventScroll: true });
  }

  /** Mark what is left after a repair, on what it made.
   * @param {Job} job @param {import("../core/types.js").Result} result */
  goOn(job, result) {
    const left = this.#left;
    if (left?.id !== job.id || !left.spots.length) return;
    this.show({ job, result, ...left }, "Repaired; what is left:");
    this.#left = null;
  }

  /** Look at a place, with what is around it; whether there is one.
   * @param {number} n */
  #go(n) {
    const [left, top, side] = this.#marked?.spots[n] ?? [0, 0, 0];
    if (!side) return false;
    const { canvas, view } = this.stage;
    view.zoom(Math.min(canvas.width, canvas.height) / (4 * side), 0, 0);
    const [x, y] = view.at(canvas.width / 2, canvas.height / 2);
    view.move(Math.round((x - left - side / 2) * view.scale), Math.round((y - top - side / 2) * view.scale));
    this.#at = n;
    this.bar.querySelectorAll("[aria-pressed]").forEach((each, m) => each.setAttribute("aria-pressed", String(m === n)));
    this.repair.disabled = false;
    this.stage.draw();
    return this.stage.dispatchEvent(new Event("view"));
  }

  /** @param {CanvasRenderingContext2D} pen @param {import("../stage/view.js").View} view */
  #draw(pen, view) {
    const px = devicePixelRatio;
    pen.font = `600 ${13 * px}px system-ui, sans-serif`;
    this.#marked?.spots.forEach(([left, top, side], n) => {
      const [x, y, wide] = [view.x + left * view.scale, view.y + top * view.scale, side * view.scale];
      for (const line of [5, 2]) {
        [pen.lineWidth, pen.strokeStyle] = [line * px, line > 2 ? "#000000" : n === this.#at ? "#ffd84a" : "#ffffff"];
        pen.strokeRect(x, y, wide, wide);
      }
      pen.fillStyle = "#000000";
      pen.fillRect(x, y, 20 * px, 20 * px);
      pen.fillStyle = pen.strokeStyle;
      pen.fillText(String(n + 1), x + 6 * px, y + 15 * px);
    });
  }

  /** Make the place anew: across a seam from the example, instead of what is seen again from elsewhere in the picture. */
  async #repair() {
    const spot = this.#marked?.spots[this.#at];
    if (!this.#marked || !spot) return;
    const { job, result, part, spots } = this.#marked;
    this.repair.disabled = true;
    const first = firstOf(job);
    const wrap = job.options.wrap ?? (job.verb === "tile" ? (job.options.axes ?? "both") : null);
    const sent = (/** @type {Spot[]} */ around, /** @type {number} */ radius, /** @type {number} */ inside) => {
      const labels = new Labels(...result.size);
      for (const [x, y, side] of around) labels.stroke([x + side / 2, y + side / 2], [x + side / 2, y + side / 2], radius * side, 1);
      return send(labels, (value) => (value ? inside : 255 - inside));
    };
    /** @type {import("../core/types.js").Options} */
    const options = { method: "graphcut", grow: 0, wrap, mask: [await sent([spot], ANEW, 255)] };
    if (part !== "joins") options.usable = [await sent(spots, SAME, 0)];
    else if (!CHANGED.some((name) => name in first.options)) options.from = first.exemplars;
    await store.bring({ result: result.id });
    const { id } = await store.start("heal", [store.exemplar?.id ?? ""], options);
    this.#left = { id, part, spots: spots.filter((other) => other !== spot) };
    store.look(id);
  }
}

/** The job that grew what a job went on from.
 * @param {Job} job @returns {Job} */
function firstOf(job) {
  const from = exemplarOf(job)?.from;
  const before = from && store.made.find((other) => other.result === from);
  return before ? firstOf(before) : job;
}
