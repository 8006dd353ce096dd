/** Bringing exemplars in: files that were dropped, pasted or picked, and built-in samples. */

import { el } from "../core/dom.js";
import { store } from "../core/store.js";
import { complain, say } from "../core/toast.js";

/** @param {DataTransfer | null} data @returns {File[]} */
export function filesOf(data) {
  return [...(data?.files ?? [])];
}

/** Bring files in: a picture, all planes of a material, or several of these.
 * @param {File[]} files */
export async function bringFiles(files) {
  if (!files[0]) return complain("Nothing to open: drop a picture, or all maps of one material.");
  const form = new FormData();
  for (const file of files) form.append("files", file, file.name);
  await brought(form, files[1] ? `${files.length} files` : files[0].name);
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

/** @param {FormData | {sample: string} | {result: string}} from @param {string} [name] of what is read, which may take a while */
async function brought(from, name) {
  const sign = name ? say(`Opening ${name} …`, true) : null;
  sign?.classList.add("opening");
  try {
    const { opened = 1, refused = [], told = [] } = await store.bring(from);
    const lines = [opened > 1 ? `${opened} examples opened.` : "", ...refused, ...told].filter(Boolean);
    if (refused.length) complain(lines.join(" "));
    else if (lines.length) say(lines.join(" "), told.length > 0);
    if (location.hash === "" || location.hash === "#start" || location.hash === "#gallery") location.hash = "#grow";
  } catch (error) {
    const line = error instanceof Error ? error.message : "";
    if (dispatchEvent(new CustomEvent("refused", { detail: line, cancelable: true }))) complain(line);
  } finally {
    sign?.remove();
  }
}

/** It stays, so that it is not swept away while the person chooses; emptied, so that the same file can be chosen again. */
const input = el("input", { type: "file", multiple: true, accept: "image/*,.exr,.hdr,.tif,.tiff,.tga,.webp" });
input.addEventListener("change", () => void bringFiles([...(input.files ?? [])]).finally(() => (input.value = "")));

/** Let the person pick files. */
export const pick = () => input.click();
