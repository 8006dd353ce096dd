/** A material for elsewhere: maps that are proposed where they are missing, and files as an engine reads them. */

import { post } from "../core/api.js";
import { button, el, fill } from "../core/dom.js";
import { store } from "../core/store.js";
import { say, tried } from "../core/toast.js";

const ENGINES = { unreal: "Unreal", unity: "Unity", godot: "Godot", blender: "Blender", gltf: "glTF" };

/** The engine that was asked for last. */
let engine = "unreal";

/** A button that makes an example of the one that is worked with, with the maps that it lacks; null where it has them.
 * @param {string[]} planes that are there @param {() => Promise<unknown>} [first] brings what is worked with */
export function proposing(planes, first) {
  if (planes.includes("normal") && planes.includes("height")) return null;
  const propose = button("Propose maps", () => {
    propose.disabled = true;
    void tried(async () => {
      await first?.();
      if (store.exemplar) store.choose(await post(`/api/exemplars/${store.exemplar.id}/edit`, { propose: true }));
      say("The maps are there; it is the picture that is worked with now.");
    }).finally(() => (propose.disabled = false));
  }, { class: "framed", title: "Height, normal and roughness, guessed from brightness" });
  return propose;
}

/** A choice of an engine, and a zip for it.
 * @param {string} what is exported, in words @param {string} at where what is taken lies @param {string[]} planes
 * @param {() => Promise<unknown>} [first] brings what maps are proposed of */
export function forEngine(what, at, planes, first) {
  const choice = el("select", { class: "field", "aria-label": "For", onchange: () => [(engine = choice.value), point()] });
  fill(choice, Object.entries(ENGINES).map(([value, says]) => el("option", { value, selected: value === engine }, `For ${says}`)));
  const take = el("a", { class: "button framed", download: "", onclick: () => say("The zip is in your downloads.") }, "Zip");
  const point = () => Object.assign(take, { href: `${at}/for/${engine}.zip`, title: `As ${choice.selectedOptions[0]?.text.slice(4)} reads it` });
  point();
  const alone = planes.length === 1 && el("p", { class: "quiet small" }, "Only the base colour goes.");
  return el("div", { class: "engine" }, el("p", { class: "quiet small" }, `Export ${what}`), el("div", { class: "pairs" }, choice, take), alone, alone && proposing(planes, first));
}
