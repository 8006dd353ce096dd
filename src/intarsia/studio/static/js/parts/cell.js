/** A job as a small picture: as it grows, and when it is done. */

import { el, fill } from "../core/dom.js";
import { store } from "../core/store.js";
import { busy, inPlain, state, title } from "../core/words.js";
import { bar } from "./progress.js";

export class Cell {
  picture = el("img", { alt: "", decoding: "async" });
  over = el("span", { class: "over", "aria-hidden": "true" });
  element;
  /** @type {HTMLElement} what is put into a row or a grid */
  place;
  #shown = "";

  /** @param {string} id of the job @param {number} side px that are asked for
   * @param {(job: import("../core/types.js").Job, event: MouseEvent) => void} act */
  constructor(id, side, act) {
    this.id = id;
    this.side = side;
    this.element = el("button", {
      type: "button", class: "thumb", onclick: (/** @type {MouseEvent} */ e) => {
        const job = store.jobs.get(id);
        if (job) act(job, e);
      },
    }, this.picture, this.over);
    this.element.dataset.job = id;
    this.place = this.element;
  }

  /** Show how the job is now. */
  show() {
    const job = store.jobs.get(this.id);
    if (!job) return;
    const number = store.previews.get(job.id);
    const preview = busy(job) && number !== undefined ? `/api/jobs/${job.id}/preview.png?number=${number}` : "";
    const src = job.state === "done" ? store.thumb(job, this.side) : preview;
    if (!preview) this.picture.style.background = "";
    else if (!this.#shown) this.picture.style.background = `center / contain no-repeat url("${src}")`; // seen where nothing has grown yet
    if (src && src !== this.#shown) this.picture.src = this.#shown = src;
    this.picture.hidden = !src;
    this.element.setAttribute("aria-label", [title(job), state(job), job.error].filter(Boolean).join(", "));
    this.element.title = title(job);
    if (job.state === "done") fill(this.over);
    else fill(this.over, busy(job) ? bar(job) : el("span", { class: "ended small" }, this.side > 400 ? inPlain(job.error ?? state(job)) : state(job)));
  }
}

/** Keep cells for these jobs in a place, in this order; those that are there already stay, and so does the focus.
 * @param {HTMLElement} place @param {Map<string, Cell>} cells @param {string[]} ids
 * @param {(id: string) => Cell} make */
export function arrange(place, cells, ids, make) {
  for (const [id, cell] of cells) {
    if (ids.includes(id)) continue;
    cell.place.remove();
    cells.delete(id);
  }
  const focused = /** @type {HTMLElement | null} */ (place.contains(document.activeElement) ? document.activeElement : null);
  ids.forEach((id, n) => {
    const cell = cells.get(id) ?? make(id);
    cells.set(id, cell);
    if (place.children[n] !== cell.place) place.insertBefore(cell.place, place.children[n] ?? null);
    cell.show();
  });
  if (focused !== document.activeElement) focused?.focus({ preventScroll: true });
}
