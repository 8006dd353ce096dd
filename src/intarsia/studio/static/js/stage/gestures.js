/** Wheel, drag, pinch and keys move a view. A tool may take strokes first; the middle button and two fingers always move. */

import { typing } from "../core/dom.js";

/**
 * @typedef {object} Stroke what a tool does with a pointer that is down; places are picture pixels
 * @property {(x: number, y: number, event: PointerEvent) => boolean} down whether it takes the stroke
 * @property {(x: number, y: number, event: PointerEvent) => void} move
 * @property {(x: number, y: number, event: PointerEvent) => void} up
 * @property {() => void} stop a second finger came: undo what the first began
 */

/** @type {Gestures[]} those of stages on the page, that which was touched last before the others */
let all = [];
addEventListener("keydown", (e) => all.find((each) => each.seen)?.key(e));
addEventListener("keyup", (e) => e.key === " " && all.forEach((each) => (each.held = false)));
addEventListener("blur", () => all.forEach((each) => (each.held = false)));

/** Controls that arrow keys belong to. */
const WALKED = "input, select, textarea, [role=slider], [role=radio], .menu";

export class Gestures {
  /** @type {Map<number, {x: number, y: number}>} pointers that are down, in device pixels */
  #down = new Map();
  /** @type {Stroke | null} */ #stroke = null;
  /** Whether the space bar is, and what is touched moves the view. */
  held = false;

  /** @param {import("./ground.js").Ground<import("./view.js").View>} ground what is touched, and moved */
  constructor(ground) {
    this.ground = ground;
    ground.addEventListener("wheel", (e) => this.#wheel(e), { passive: false });
    ground.addEventListener("pointerdown", (e) => this.#begin(e));
    ground.addEventListener("pointermove", (e) => this.#go(e));
    ground.addEventListener("pointerup", (e) => this.#end(e));
    ground.addEventListener("pointercancel", (e) => this.#end(e));
    ground.addEventListener("focus", () => this.listen());
    ground.addEventListener("dblclick", () => ground.tool || this.#toggle());
  }

  /** Keys belong to it from now on, as long as its stage is seen. */
  listen() {
    all = [this, ...all.filter((each) => each !== this && each.ground.isConnected)];
  }

  /** Whether the middle of its stage is on the screen, and nothing lies over it. */
  get seen() {
    const { left, top, width, height } = this.ground.getBoundingClientRect();
    return this.ground.contains(document.elementFromPoint(left + width / 2, top + height / 2));
  }

  /** @param {MouseEvent} event @returns {{x: number, y: number}} device pixels of the stage */
  #place(event) {
    const box = this.ground.getBoundingClientRect();
    const ratio = devicePixelRatio;
    return { x: (event.clientX - box.left) * ratio, y: (event.clientY - box.top) * ratio };
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const { view } = this.ground;
    const step = event.deltaMode === 1 ? 16 : 1;
    if (event.shiftKey) view.move(-(event.deltaX + event.deltaY) * step, 0);
    else {
      const { x, y } = this.#place(event);
      view.zoom(view.scale * Math.exp(-event.deltaY * step * (event.ctrlKey ? 0.01 : 0.002)), x, y);
    }
    this.ground.redraw(true);
  }

  /** @param {PointerEvent} event */
  #begin(event) {
    if (event.button === 2) return;
    this.ground.focus({ preventScroll: true });
    const place = this.#place(event);
    this.#down.set(event.pointerId, place);
    this.ground.setPointerCapture(event.pointerId);
    if (this.#down.size > 1) {
      this.#stroke?.stop();
      this.#stroke = null;
      return;
    }
    const { tool } = this.ground;
    const [u, v] = this.ground.view.at(place.x, place.y);
    if (tool && event.button === 0 && !this.held && tool.down(u, v, event)) this.#stroke = tool;
  }

  /** @param {PointerEvent} event */
  #go(event) {
    const before = this.#down.get(event.pointerId);
    if (!before) return;
    if (this.#stroke) {
      const all = event.getCoalescedEvents();
      for (const each of all.length ? all : [event]) {
        const place = this.#place(each);
        this.#stroke.move(...this.ground.view.at(place.x, place.y), each);
      }
      return;
    }
    const now = this.#place(event);
    const others = [...this.#down.entries()].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    const { view } = this.ground;
    const other = others[0];
    if (other) {
      const was = Math.hypot(before.x - other.x, before.y - other.y);
      const is = Math.hypot(now.x - other.x, now.y - other.y);
      view.move((now.x - before.x) / 2, (now.y - before.y) / 2);
      if (was > 8) view.zoom((view.scale * is) / was, (now.x + other.x) / 2, (now.y + other.y) / 2);
    } else view.move(now.x - before.x, now.y - before.y);
    this.#down.set(event.pointerId, now);
    this.ground.redraw(true);
  }

  /** @param {PointerEvent} event */
  #end(event) {
    if (!this.#down.delete(event.pointerId)) return;
    if (this.#stroke) {
      const place = this.#place(event);
      this.#stroke.up(...this.ground.view.at(place.x, place.y), event);
      this.#stroke = null;
    }
    this.ground.redraw(false);
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const at = event.target instanceof HTMLElement ? event.target : document.body;
    if (event.defaultPrevented || typing(event) || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key.startsWith("Arrow") && at.closest(WALKED)) return;
    if (event.key === " " && at !== document.body && at !== this.ground) return;
    const { ground } = this;
    const { view } = ground;
    const middle = { x: (ground.clientWidth * devicePixelRatio) / 2, y: (ground.clientHeight * devicePixelRatio) / 2 };
    const far = event.shiftKey ? 200 : 50;
    /** @type {Record<string, () => void>} */
    const keys = {
      ArrowLeft: () => view.move(far, 0),
      ArrowRight: () => view.move(-far, 0),
      ArrowUp: () => view.move(0, far),
      ArrowDown: () => view.move(0, -far),
      "+": () => view.zoom(view.scale * 1.25, middle.x, middle.y),
      "=": () => view.zoom(view.scale * 1.25, middle.x, middle.y),
      "-": () => view.zoom(view.scale / 1.25, middle.x, middle.y),
      "0": () => ground.fit(),
      "1": () => ground.whole(),
      " ": () => (this.held = true),
    };
    const act = keys[event.key];
    if (!act) return;
    event.preventDefault();
    act();
    this.ground.redraw(true);
  }

  #toggle() {
    if (this.ground.view.fitted) this.ground.whole();
    else this.ground.fit();
  }
}
