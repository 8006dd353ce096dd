/** The contact sheet: what was asked for together, side by side, the best score first once all are known. */

import { button, el, fill, Living, there } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { busy, facts, judged, title } from "../core/words.js";
import { awaited } from "./awaited.js";
import { arrange, Cell } from "./cell.js";

export class Sheet extends Living {
  grid = el("div", { class: "sheet-grid" });
  count = el("span", { class: "quiet small number facts" });
  stop = button("Cancel", () => this.#cancel(), { class: "framed" });
  head = el("div", { class: "head" }, el("h2", {}, "Contact sheet"), this.count, this.stop);
  /** @type {Map<string, Cell>} */ #cells = new Map();
  observer = new ResizeObserver(() => this.#fit(store.sheet.length));

  connectedCallback() {
    this.className = "sheet";
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", "Contact sheet");
    fill(this, this.head, this.grid);
    this.observer.observe(this.grid);
    store.on(["jobs", "chosen", "preview"], () => this.show(), this.gone.signal);
  }

  disconnectedCallback() {
    super.disconnectedCallback();
    this.observer.disconnect();
  }

  /** As large as they may be so that all can be seen.
   * @param {number} count */
  #fit(count) {
    const gap = 12;
    let best = { across: 1, side: 0 };
    for (let across = 1; across <= count; across += 1) {
      const wide = (this.grid.clientWidth - gap) / across - gap;
      const high = (this.grid.clientHeight - gap) / Math.ceil(count / across) - gap;
      if (Math.min(wide, high) > best.side) best = { across, side: Math.floor(Math.min(wide, high)) };
    }
    this.grid.style.setProperty("--across", String(best.across));
    this.grid.style.setProperty("--side", `${best.side}px`);
  }

  /** End all that is under way. */
  #cancel() {
    const open = store.sheet.map((id) => store.jobs.get(id)).filter(there).filter(busy);
    void tried(() => Promise.all(open.map((job) => store.change(job, "cancel"))));
  }

  show() {
    this.hidden = !store.spread;
    if (this.hidden) return;
    const jobs = store.sheet.map((id) => store.jobs.get(id)).filter(there);
    const known = jobs.every((job) => !busy(job) && (job.state !== "done" || typeof job.score === "number"));
    if (known) jobs.sort((a, b) => (b.score ?? -1) - (a.score ?? -1));
    arrange(this.grid, this.#cells, jobs.map((job) => job.id), (id) => {
      const cell = new Cell(id, 640, (job) => store.look(job.id));
      cell.element.append(el("span", { class: "caption" }, el("span"), el("strong", { class: "number" }), el("span", { class: "verdict" })));
      const job = () => store.jobs.get(id);
      const stop = button("Cancel", () => void tried(async () => busy(job()) && store.change(/** @type {import("../core/types.js").Job} */ (job()), "cancel")), { icon: icon("close"), bare: true });
      cell.place = el("div", { class: "cell" }, cell.element, stop);
      return cell;
    });
    for (const job of jobs) {
      const place = this.#cells.get(job.id)?.place;
      const [name, score, verdict] = place?.querySelectorAll(".caption > *") ?? [];
      const stop = /** @type {HTMLElement | null} */ (place?.lastElementChild ?? null);
      if (!name || !score || !verdict || !stop) continue;
      name.textContent = title(job);
      score.textContent = typeof job.score === "number" ? String(Math.round(job.score)) : "";
      verdict.textContent = typeof job.score === "number" ? judged(job.score) : "";
      stop.hidden = !busy(job);
    }
    this.#fit(jobs.length);
    const done = jobs.filter((job) => job.state === "done").length;
    this.count.textContent = facts(`${done} of ${jobs.length}`, awaited(jobs.find((job) => job.state === "running") ?? jobs.find(busy) ?? null));
    this.stop.hidden = !jobs.some(busy);
  }
}

customElements.define("contact-sheet", Sheet);
