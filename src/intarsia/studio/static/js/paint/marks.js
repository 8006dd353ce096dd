/** What was painted over an exemplar, kept by the studio after each stroke, and painted again when the page comes back. */

import { numbers } from "../core/api.js";
import { kept } from "../core/kept.js";
import { store } from "../core/store.js";
import { tried } from "../core/toast.js";
import { Labels } from "./labels.js";
import { send } from "./send.js";

/** @typedef {"source" | "target" | "hole" | "avoid"} Name */

/** One is sent after another, so that the last one stays. */
let sent = Promise.resolve();

/** The image that was kept, if anything was painted.
 * @param {string} exemplar @param {Name} name @returns {string | undefined} */
export function imageOf(exemplar, name) {
  return kept.of(exemplar).marks?.[name];
}

/** Keep what was painted.
 * @param {string} exemplar @param {Name} name @param {Labels} labels
 * @param {(value: number) => number} [meaning] what is kept for a number; by default itself */
export function keep(exemplar, name, labels, meaning) {
  sent = sent.then(async () => {
    await tried(async () => {
      const image = labels.data.some((value) => value > 0) ? await send(labels, meaning) : undefined;
      kept.set({ marks: { ...kept.of(exemplar).marks, [name]: image } }, exemplar);
    });
  });
  return sent;
}

/** What was painted over the exemplar that is worked with; at first what was kept of it.
 * @param {Map<string, Labels>} known of each exemplar @param {Name} name @param {() => void} came what was kept is there
 * @param {(value: number) => number} [meaning] of what was kept @returns {Labels | null} */
export function labelsOf(known, name, came, meaning) {
  const { exemplar } = store;
  if (!exemplar) return null;
  const labels = known.get(exemplar.id) ?? new Labels(exemplar.width, exemplar.height);
  if (!known.has(exemplar.id)) void restore(exemplar.id, name, labels, meaning).then(came);
  known.set(exemplar.id, labels);
  return labels;
}

/** Paint what was kept.
 * @param {string} exemplar @param {Name} name @param {Labels} labels
 * @param {(value: number) => number} [meaning] of what was kept */
export async function restore(exemplar, name, labels, meaning = (value) => value) {
  const image = imageOf(exemplar, name);
  if (!image) return;
  await tried(async () => {
    const { width, height, data } = await numbers(`/api/images/${image}.png`);
    labels.lay({ width, height, data: data.map(meaning) });
  });
}
