/** Bringing exemplars in: files that were dropped, pasted or picked, and built-in samples. */

import { el } from "../core/dom.js";
import { store } from "../core/store.js";
import { complain, tried } from "../core/toast.js";

/** @param {DataTransfer | null} data @returns {File[]} */
export function filesOf(data) {
  return [...(data?.files ?? [])];
}

/** Bring files in as one exemplar: a picture, or all planes of a material.
 * @param {File[]} files */
export async function bringFiles(files) {
  if (!files.length) return complain("Nothing to open: drop a picture, or all maps of one material.");
  const form = new FormData();
  for (const file of files) form.append("files", file, file.name);
  await brought(form);
}

/** @param {string} sample */
export async function bringSample(sample) {
  await brought({ sample });
}

/** Go on from a result: all its planes become the exemplar that is worked with.
 * @param {string} result */
export async function carryOn(result) {
  await brought({ result });
}

/** @param {FormData | {sample: string} | {result: string}} from */
async function brought(from) {
  await tried(async () => {
    await store.bring(from);
    if (location.hash === "" || location.hash === "#start" || location.hash === "#gallery") location.hash = "#grow";
  });
}

/** Let the person pick files. */
export function pick() {
  const input = el("input", { type: "file", multiple: true, accept: "image/*,.exr,.hdr,.tif,.tiff,.tga,.webp" });
  input.addEventListener("change", () => void bringFiles([...(input.files ?? [])]));
  input.click();
}
