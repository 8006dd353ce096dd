/** Names that can be given by hand, and how much of the disk all of it takes. */

import { get } from "../core/api.js";
import { button, el, fill } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { store } from "../core/store.js";
import { offer, tried } from "../core/toast.js";
import { weight } from "../core/words.js";

/** A heading that is given another name by a click, or by the button beside it.
 * @param {"jobs" | "exemplars"} kind @param {{id: string, name?: string}} row @param {"h2" | "h3"} tag
 * @param {string} [shown] where it was given no name @returns {HTMLElement} */
export function heading(kind, { id, name = "" }, tag, shown = "") {
  const says = name || shown;
  const edit = () => {
    const take = async () => {
      if (!input.isConnected) return;
      const next = input.value.trim();
      fill(place, head, pencil);
      if (next === says) return;
      if (await tried(() => store.rename(kind, id, next))) offer("Renamed", () => void tried(() => store.rename(kind, id, name)));
    };
    const key = (/** @type {KeyboardEvent} */ e) => {
      if (e.key === "Escape") input.value = says;
      if (["Enter", "Escape"].includes(e.key)) [e.preventDefault(), input.blur(), pencil.focus()]; // else Enter presses the pencil
    };
    const input = el("input", { class: "field", value: says, maxLength: 80, "aria-label": "Name", onblur: () => void take(), onkeydown: key });
    fill(place, input);
    input.select();
  };
  const head = el(tag, { class: "one-line", title: says, onclick: edit }, says);
  const pencil = button(`Rename ${says}`, edit, { icon: icon("pencil"), bare: true });
  const place = el("div", { class: "named" }, head, pencil);
  return place;
}

/** What the studio keeps on the disk, in a quiet line that names its folder.
 * @returns {HTMLElement} */
export function diskUse() {
  const line = el("span", { class: "quiet small number" });
  const tell = (/** @type {{bytes: number, folder: string}} */ { bytes, folder }) => [(line.textContent = `${weight(bytes)} on disk`), (line.title = folder)];
  get("/api/disk").then(tell, () => {});
  return line;
}
