/** What can be taken from a result: files, the command, the lines of Python. */

import { bytes, fileOf } from "../core/api.js";
import { button, el } from "../core/dom.js";
import { icon } from "../core/icons.js";
import { planesOf, store } from "../core/store.js";
import { copied, tried } from "../core/toast.js";
import { weight } from "../core/words.js";
import { carryOn } from "./bring.js";
import { forEngine } from "./material.js";
import { menu } from "./menu.js";

/** What a press on *Continue from this* does, in a sentence. */
export const ONWARD = "It becomes the picture that is worked with, all its maps";

/** @param {import("../core/types.js").Result} result @param {string} plane its picture
 * @param {boolean} onward whether there is a button to go on from it @returns {HTMLElement[]} */
export function resultActions(result, plane, onward) {
  const main = result.files.find((file) => file.holds === plane) ?? result.files[0];
  const more = el("div", { class: "menu", role: "group", "aria-label": "Downloads" });
  const planes = planesOf(result);
  const files = [...result.files].sort((a, b) => rank(a, planes) - rank(b, planes));
  for (const file of files) more.append(link(fileOf(result, file.name), "", file.name, weight(file.bytes)));
  more.append(link(`/api/results/${result.id}/all.zip`, "", "All as a zip", "with its steps"));
  if (result.verb !== "render" && main) more.append(reportButton(result, main.name));
  const needed = needing(Object.keys(result.inputs), "the zip");
  more.append(button("Copy as Python", () => void copied(result.python, `Python copied${needed}`), { title: result.python }));
  more.append(forEngine("this result", `/api/results/${result.id}`, planes, () => store.bring({ result: result.id })));
  const around = menu(button("More to take", () => {}, { icon: icon("more"), bare: true }), more);
  const command = button("Command", () => void copied(result.command, `Command copied${needed}`), { icon: icon("copy"), title: result.command });
  const made = [command, around];
  if (onward) made.unshift(button("Continue from this", () => void carryOn(result.id), { icon: icon("onward"), title: `Continue from this: ${ONWARD}` }));
  if (main) {
    const download = el("a", { class: "button framed", href: fileOf(result, main.name), download: "" }, icon("down"), el("span", { class: "label" }, planes.length > 1 ? "Download this map" : "Download"));
    made.unshift(download);
  }
  return made;
}

/** @param {string} name */
function stem(name) {
  return name.replace(/\.\w+$/, "");
}

/** Which files a command reads, and where they are, in words.
 * @param {string[]} names @param {string} where */
export function needing(names, where) {
  if (!names.length) return "";
  const listed = names.length > 3 ? `${names.length} files` : names.join(" and ");
  return `; it needs ${listed}, which ${names.length > 1 ? "are" : "is"} in ${where}`;
}

/** A page on how good a result is, made when it is asked for.
 * @param {import("../core/types.js").Result} result @param {string} name of its picture */
function reportButton(result, name) {
  const take = async () => {
    if (made.ariaBusy === "true") return;
    made.ariaBusy = "true";
    made.textContent = "Report …";
    await tried(async () => {
      const page = new Blob([await bytes(`/api/results/${result.id}/report.html`)], { type: "text/html" });
      const href = URL.createObjectURL(page);
      const { method, seed } = result.options;
      link(href, [stem(name), method, seed && `s${seed}`, "report.html"].filter(Boolean).join("_"), "").click();
      setTimeout(() => URL.revokeObjectURL(href), 60_000);
    });
    made.textContent = "Report";
    made.ariaBusy = "false";
  };
  const made = button("Report", () => void take(), { title: "A page on how good it is, part by part" });
  return made;
}

/** Planes come first, in their order.
 * @param {import("../core/types.js").Made} file @param {string[]} planes */
function rank(file, planes) {
  const at = planes.indexOf(file.holds);
  return at < 0 ? planes.length : at;
}

/** @param {string} href @param {string} name of the file, where the server names none @param {string} says @param {string} [heavy] */
function link(href, name, says, heavy) {
  return el("a", { class: "button", href, download: name }, says, heavy && el("span", { class: "quiet number weight" }, heavy));
}
