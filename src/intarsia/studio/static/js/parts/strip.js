/** Everything that was made of this exemplar, small, in one line below the stage. */

import { Living } from "../core/dom.js";
import { store } from "../core/store.js";
import { arrange, Cell } from "./cell.js";

const MOST = 60;

export class Strip extends Living {
  /** @type {Map<string, Cell>} */ #cells = new Map();
  /** @type {(id: string) => void} */ act = (id) => store.look(id);
  /** @type {string | null} the other one of a comparison */
  other = null;

  connectedCallback() {
    this.className = "strip";
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", "Made of this example");
    store.on(["jobs", "exemplar", "chosen", "preview"], () => this.show(), this.gone.signal);
  }

  show() {
    const own = store.made.filter((job) => job.exemplars.includes(store.exemplar?.id ?? "")).slice(0, MOST);
    this.hidden = own.length === 0;
    arrange(this, this.#cells, own.map((job) => job.id), (id) => new Cell(id, 160, (job) => this.act(job.id)));
    for (const [id, cell] of this.#cells) {
      cell.element.setAttribute("aria-pressed", String(id === store.chosen && !store.spread));
      cell.element.classList.toggle("other", id === this.other);
    }
  }
}

customElements.define("result-strip", Strip);
