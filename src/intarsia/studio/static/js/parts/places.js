/** Places where a result is not good, marked on the stage by numbers: one is gone to, and repaired. */

import { button, el, fill } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { exemplarOf, store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { Labels } from "../paint/labels.js";
import { send } from "../paint/send.js";

/** @typedef {import("../core/types.js").Job} Job */
/** @typedef {import("../core/types.js").Result} Result */
/** @typedef {[number, number, number]} Spot a square: its left and upper border and its side, px of the result */

/** Sides of a square: radius of what is made anew, and of what is not taken in its place. */
const ANEW = 1.2;
const SAME = 0.8;

/** Options of growing after which an example cannot be taken from as it is. */
const CHANGED = ["mask", "crop", "flatten", "scale", "avoid"];

export class Places {
  bar = el("div", { class: "places", role: "group", "aria-label": "Marked places", hidden: true });
  /** @type {{job: Job, result: Result, part: string, spots: Spot[]} | null} */
  #shown = null;
  #at = -1;

  /** @param {import("../stage/stage.js").Stage} stage */
  constructor(stage) {
    this.stage = stage;
    stage.append(this.bar);
    this.bar.addEventListener("pointerdown", (e) => e.stopPropagation());
  }

  /** Mark places, or none any more.
   * @param {{job: Job, result: Result, part: string, spots: Spot[]} | null} shown @param {string} [says] */
  show(shown, says = "") {
    this.#shown = shown;
    this.#at = -1;
    this.bar.hidden = !shown;
    this.stage.marks = shown && ((pen, view) => this.#draw(pen, view));
    this.stage.tool = shown && { down: (x, y) => this.#press(x, y), move() {}, up() {}, stop() {} };
    this.stage.draw();
    const numbers = shown?.spots.map((_, n) => button(String(n + 1), () => this.#go(n), { "aria-label": `Place ${n + 1}`, "aria-pressed": "false" })) ?? [];
    this.repair = button("Repair here", () => void this.#repair(), { class: "strong", disabled: true, title: "Make this place anew: a step that can be gone back from" });
    const away = button("Hide the marks", () => this.show(null), { icon: icon("close"), bare: true });
    fill(this.bar, el("span", { role: "status" }, says), el("span", { class: "segments" }, numbers), this.repair, away);
    if (shown) numbers[0]?.focus({ preventScroll: true });
  }

  /** @param {number} x of the result @param {number} y */
  #press(x, y) {
    const at = this.#shown?.spots.findIndex(([left, top, side]) => x >= left && y >= top && x < left + side && y < top + side) ?? -1;
    if (at >= 0) this.#go(at);
    return at >= 0;
  }

  /** Look at a place, with what is around it.
   * @param {number} n */
  #go(n) {
    const { stage } = this;
    const [left, top, side] = this.#shown?.spots[n] ?? [0, 0, 1];
    const { width, height } = stage.canvas;
    const { view } = stage;
    view.zoom(Math.min(width, height) / (4 * side), 0, 0);
    view.move(Math.round(width / 2 - view.x - (left + side / 2) * view.scale), Math.round(height / 2 - view.y - (top + side / 2) * view.scale));
    this.#at = n;
    this.bar.querySelectorAll(".segments .button").forEach((each, m) => each.setAttribute("aria-pressed", String(m === n)));
    if (this.repair) this.repair.disabled = false;
    stage.draw();
    stage.dispatchEvent(new Event("view"));
  }

  /** @param {CanvasRenderingContext2D} pen @param {import("../stage/view.js").View} view */
  #draw(pen, view) {
    const px = devicePixelRatio;
    pen.font = `600 ${13 * px}px system-ui, sans-serif`;
    this.#shown?.spots.forEach(([left, top, side], n) => {
      const [x, y, wide] = [view.x + left * view.scale, view.y + top * view.scale, side * view.scale];
      for (const [colour, line] of /** @type {[string, number][]} */ ([["#000000", 5], [n === this.#at ? "#ffd84a" : "#ffffff", 2]])) {
        [pen.strokeStyle, pen.lineWidth] = [colour, line * px];
        pen.strokeRect(x, y, wide, wide);
      }
      pen.fillStyle = "#000000";
      pen.fillRect(x, y, 20 * px, 20 * px);
      pen.fillStyle = n === this.#at ? "#ffd84a" : "#ffffff";
      pen.fillText(String(n + 1), x + 6 * px, y + 15 * px);
    });
  }

  /** Make the place anew, as a step after this result. Seams are covered from the example; what is seen again gives way to
   * something else from the picture, none of the marked places. */
  async #repair() {
    const { job, result, part, spots } = this.#shown ?? {};
    const spot = spots?.[this.#at];
    if (!job || !result || !spot || !this.repair) return;
    this.repair.disabled = true;
    await tried(async () => {
      const wrap = job.options.wrap ?? (job.verb === "tile" ? job.options.axes ?? "both" : null);
      /** @type {import("../core/types.js").Options} */
      const options = { method: "graphcut", grow: 0, wrap, mask: [await sent(result, [spot], ANEW, 255)] };
      const first = firstOf(job);
      if (part !== "joins") options.usable = [await sent(result, spots, SAME, 0)];
      else if (!CHANGED.some((name) => name in first.options)) options.from = first.exemplars;
      await store.bring({ result: result.id });
      store.look((await store.start("heal", [store.exemplar?.id ?? ""], options)).id);
    });
    this.repair.disabled = false;
  }
}

/** The job that grew what a job went on from.
 * @param {Job} job @returns {Job} */
function firstOf(job) {
  const from = exemplarOf(job)?.from;
  const before = from && store.made.find((other) => other.result === from);
  return before ? firstOf(before) : job;
}

/** Send a mask with round spots.
 * @param {Result} result @param {Spot[]} spots @param {number} radius in sides @param {0 | 255} inside */
async function sent(result, spots, radius, inside) {
  const labels = new Labels(...result.size);
  for (const [left, top, side] of spots) {
    const middle = /** @type {[number, number]} */ ([left + side / 2, top + side / 2]);
    labels.stroke(middle, middle, radius * side, 1);
  }
  return send(labels, (value) => (value ? inside : 255 - inside));
}
