/** The frame around all rooms: which room, how the server is, light or dark; and files that are dropped or pasted anywhere. */

import { button, el, fill, typing } from "./core/dom.js";
import { icon } from "./core/icons.js";
import { exemplarOf, store } from "./core/store.js";
import { turn } from "./core/theme.js";
import { takeOffer } from "./core/toast.js";
import { bringFiles, filesOf, pick } from "./parts/bring.js";
import { EndlessRoom } from "./rooms/endless.js";
import { FoundRoom } from "./rooms/found.js";
import { GalleryRoom } from "./rooms/gallery.js";
import { GrowRoom } from "./rooms/grow.js";
import { MendRoom } from "./rooms/mend.js";
import { PaintRoom } from "./rooms/paint.js";
import { StartRoom } from "./rooms/start.js";

/** @type {{name: string, title: string, room: new () => HTMLElement, looks?: boolean, bare?: boolean}[]} */
const ROOMS = [
  { name: "grow", title: "Grow", room: GrowRoom, looks: true },
  { name: "found", title: "Inspect", room: FoundRoom },
  { name: "paint", title: "Paint", room: PaintRoom, looks: true },
  { name: "mend", title: "Mend", room: MendRoom, looks: true },
  { name: "endless", title: "Endless", room: EndlessRoom },
  { name: "gallery", title: "Gallery", room: GalleryRoom, bare: true },
];

class Shell extends HTMLElement {
  main = el("main", { class: "room", id: "room" });
  status = el("span", { class: "status quiet small", role: "status" });
  nav = el("nav", { class: "rooms", "aria-label": "Rooms" });
  #links = ROOMS.map((r) => el("a", { class: "button", href: `#${r.name}` }, r.title));
  /** @type {string} what is shown now */
  #shown = "";
  /** Whether the page looks at what the address names: not before all that the server has was told. */
  #arrived = false;
  /** @type {string} the job that the address names, where it is not known yet */
  #missed = "";

  connectedCallback() {
    const theme = button("Light or dark", turn, { icon: icon("dark"), bare: true });
    const mark = el("a", { class: "mark", href: "#start", "aria-label": "intarsia studio: begin" }, "intarsia");
    fill(this.nav, this.#links);
    this.open = button("Open", pick, { icon: icon("add"), title: "Open a picture, or several" });
    fill(this, el("header", { class: "top" }, mark, this.open, this.nav, this.status, theme), this.main);
    store.on(["warm", "here"], () => this.#tell());
    store.on(["exemplar", "jobs"], () => (this.#arrived && !store.jobs.has(this.#missed) ? this.#route() : this.#arrive()));
    store.addEventListener("chosen", () => this.#address());
    addEventListener("hashchange", () => this.#arrive());
    this.#listen();
  }

  #tell() {
    const { done, total } = store.warm;
    if (!store.here) this.status.textContent = "The studio does not answer";
    else this.status.textContent = done < total ? `Getting ready, once on this computer: ${done} of ${total}` : "";
  }

  /** Look at what the address names: a room, and in it a job, or the contact sheet. */
  #arrive() {
    const [name, seen = ""] = location.hash.slice(1).split("/");
    this.#arrived = store.loaded;
    const job = store.jobs.get(seen);
    this.#missed = job ? "" : seen;
    const exemplar = job && exemplarOf(job);
    if (exemplar && exemplar.id !== store.exemplar?.id) store.choose(exemplar);
    if (ROOMS.some((r) => r.looks && r.name === name)) {
      if (seen === "sheet") store.spreadOut(store.sheet);
      else if (store.spread || store.chosen !== (job?.id ?? null)) store.look(job?.id ?? null);
    }
    this.#route();
  }

  /** Tell in the address what is looked at. */
  #address() {
    const seen = store.spread ? "sheet" : store.chosen;
    const at = (/** @type {string} */ name) => (seen ? `#${name}/${seen}` : `#${name}`);
    this.#links[0]?.setAttribute("href", at("grow"));
    const room = ROOMS.find((r) => r.looks && r.name === this.#shown);
    if (room && (seen || location.hash) && location.hash !== at(room.name)) location.hash = at(room.name);
  }

  #route() {
    const asked = location.hash.slice(1).split("/")[0];
    const room = ROOMS.find((r) => r.name === asked) ?? ROOMS[0];
    if (!room) return;
    const start = asked === "start" || (!store.exemplar && !room.bare);
    const name = start ? "start" : room.name;
    for (const link of this.#links) {
      if (link.hash.split("/")[0] === `#${name}`) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
    this.nav.hidden = !store.exemplar && !store.made.length;
    if (this.open) this.open.hidden = start;
    if (name === this.#shown) return;
    this.#shown = name;
    fill(this.main, start ? new StartRoom() : new room.room());
  }

  /** Undo the last change in the room that is shown, or what was offered to be undone after it; or make it again.
   * @param {KeyboardEvent} event */
  #undo(event) {
    const key = event.key.toLowerCase();
    if (!(event.ctrlKey || event.metaKey) || event.altKey || !["y", "z"].includes(key)) return;
    if (typing(event) && !(event.target instanceof HTMLSelectElement)) return;
    event.preventDefault();
    /** @type {import("./core/past.js").Past | undefined} */
    const past = /** @type {any} */ (this.main.firstElementChild)?.past;
    if (key === "y" || event.shiftKey) past?.redo();
    else if (!takeOffer(past?.done.at(-1)?.at ?? 0)) past?.undo();
  }

  #listen() {
    addEventListener("keydown", (e) => this.#undo(e));
    let depth = 0;
    const over = (/** @type {number} */ by) => {
      depth = Math.max(0, depth + by);
      this.classList.toggle("over", depth > 0);
    };
    addEventListener("dragenter", () => over(1));
    addEventListener("dragleave", () => over(-1));
    addEventListener("dragover", (e) => e.preventDefault());
    addEventListener("drop", (e) => {
      e.preventDefault();
      over(-depth);
      void bringFiles(filesOf(e.dataTransfer));
    });
    document.addEventListener("paste", (e) => {
      const files = filesOf(e.clipboardData);
      if (files.length) void bringFiles(files);
    });
  }
}

customElements.define("studio-shell", Shell);
