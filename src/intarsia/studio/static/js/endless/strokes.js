/** What is painted on an endless canvas: how much it is jittered where. Undone and redone; kept for each exemplar. */

import { say } from "../core/toast.js";
import { Kit } from "../paint/brush.js";
import { History } from "../paint/history.js";

/** @typedef {{radius: number, strength: number | null, points: [number, number][]}} Stroke `strength` null: erased */
/** @typedef {{ground: number, strokes: readonly Stroke[]}} Painted `ground`: what holds where nothing was painted */

/** @type {Painted} */
const EMPTY = { ground: 1, strokes: [] };
const MOST = 500;
const POINTS = 5000;
const FAR = 1000;

/** Undo and redo of whole states, which share their strokes. */
class States extends History {
  /** @type {Painted[]} */
  before = [];
  /** @type {Painted[]} */
  after = [];
  now = EMPTY;

  /**
   * @param {Painted} next
   * @param {boolean} [together] it goes on with the change before
   */
  take(next, together = false) {
    if (!together) this.before.push(this.now);
    this.after = [];
    this.now = next;
    this.dispatchEvent(new Event("change"));
  }

  get canUndo() {
    return this.before.length > 0;
  }

  get canRedo() {
    return this.after.length > 0;
  }

  undo() {
    this.#step(this.before, this.after);
  }

  redo() {
    this.#step(this.after, this.before);
  }

  /**
   * @param {Painted[]} from
   * @param {Painted[]} to
   */
  #step(from, to) {
    const next = from.pop();
    if (!next) return;
    to.push(this.now);
    this.now = next;
    this.dispatchEvent(new Event("change"));
  }
}

/** The brush, and all that it has painted. */
export class Strokes extends Kit {
  size = 128;
  /** How much is jittered where it paints, 0 to 1. */
  strength = 0;
  /** Whether strokes are shown when their tiles are there, too. */
  shown = false;
  history = new States();
  /** @type {Stroke | null} the one that is being drawn */
  drawing = null;
  /** @type {Map<string, States>} */
  #kept = new Map();
  #slid = 0;

  constructor() {
    super();
    /** @type {import("../paint/brush.js").Tool} */
    this.tool = "move";
  }

  /** @param {Partial<{tool: import("../paint/brush.js").Tool, size: number, value: number, strength: number, shown: boolean}>} change */
  set(change) {
    super.set(change.tool === "fill" ? { ...change, tool: "brush" } : change);
  }

  /** @param {string} exemplar whose canvas is painted on */
  turn(exemplar) {
    const known = this.#kept.get(exemplar) ?? new States();
    if (!this.#kept.has(exemplar)) known.addEventListener("change", () => this.tell());
    this.#kept.set(exemplar, known);
    this.history = known;
    this.tell();
  }

  get painted() {
    return this.history.now;
  }

  /** @param {number} ground 0 to 1; what is moved along within a moment is undone at once */
  level(ground) {
    const at = Date.now();
    this.history.take({ ...this.painted, ground }, at - this.#slid < 700);
    this.#slid = at;
  }

  clear() {
    if (this.painted.strokes.length) this.history.take({ ...this.painted, strokes: [] });
  }

  /** @returns {Painted | null} what is sent: nothing where all is as the method has it */
  get jitter() {
    return this.painted.strokes.length || this.painted.ground !== 1 ? this.painted : null;
  }

  /**
   * @param {number} x
   * @param {number} y
   * @param {boolean} erase
   */
  begin(x, y, erase) {
    this.drawing = { radius: Math.max(1, this.size / 2), strength: erase ? null : this.strength, points: [whole(x, y)] };
  }

  /**
   * Go on to a place; places that lie close are left out.
   * @param {number} x
   * @param {number} y
   * @param {boolean} [last]
   */
  go(x, y, last = false) {
    const stroke = this.drawing;
    const from = stroke?.points.at(-1);
    if (!stroke || !from) return;
    const far = Math.hypot(x - from[0], y - from[1]);
    if (far < (last ? 1 : Math.max(1, stroke.radius / 4))) return;
    for (let n = 1, steps = Math.ceil(far / FAR); n <= steps; n += 1) {
      stroke.points.push(whole(from[0] + ((x - from[0]) * n) / steps, from[1] + ((y - from[1]) * n) / steps));
    }
  }

  end() {
    const stroke = this.drawing;
    this.drawing = null;
    if (!stroke) return;
    const strokes = [...this.painted.strokes, stroke];
    const points = strokes.reduce((sum, each) => sum + each.points.length, 0);
    if (strokes.length > MOST || points > POINTS) say("So many strokes are no longer kept apart: undo some, or clear them");
    else this.history.take({ ...this.painted, strokes });
  }
}

/**
 * @param {number} x
 * @param {number} y
 * @returns {[number, number]}
 */
function whole(x, y) {
  return [Math.round(x), Math.round(y)];
}
