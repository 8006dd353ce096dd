/** What each method makes of the exemplar, small: asked for one after another while the choice is open, as the server has time. */

import { sketchOf } from "../core/api.js";
import { el } from "../core/dom.js";
import { store } from "../core/store.js";

export class Sketches {
  /** @type {Map<string, HTMLElement>} places that wait for a picture, by method */
  #open = new Map();
  #leave = new AbortController();

  /** Where the sketch of a method is shown.
   * @param {string} method @returns {HTMLElement} */
  place(method) {
    const place = el("span", { class: "sketch", "aria-hidden": "true" });
    this.#open.set(method, place);
    return place;
  }

  /** Ask for those that are not there yet. */
  async draw() {
    this.stop();
    const leave = (this.#leave = new AbortController());
    const exemplar = store.exemplar;
    if (!exemplar) return;
    for (const [method, place] of [...this.#open]) {
      try {
        const picture = await sketchOf(exemplar, method, leave.signal);
        if (leave.signal.aborted || !place.isConnected) return;
        this.#open.delete(method);
        if (picture) place.replaceChildren(picture);
        else place.classList.add("none");
      } catch {
        return; // closed, or the server is away: asked again when it is opened again
      }
    }
  }

  /** Nobody looks any more. */
  stop() {
    this.#leave.abort();
  }
}
