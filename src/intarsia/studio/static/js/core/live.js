/** What the server tells by itself: jobs and exemplars as they come, change and go, previews, and how warm it is. */

/**
 * @typedef {object} Listener
 * @property {(told: {done: number, total: number}) => void} warm
 * @property {(job: import("./types.js").Job) => void} job
 * @property {(told: {id: string, number: number}) => void} preview
 * @property {(exemplar: import("./types.js").Exemplar) => void} exemplar
 * @property {(told: {job?: string, exemplar?: string}) => void} gone
 * @property {(here: boolean) => void} here whether the server is heard; true again after it was away
 */

/** Listen for as long as the page is open, by the one ear that all pages of this browser share.
 * @param {Listener} listener
 * @returns {Promise<void>} until the ear hears, or cannot: who asks for lists after that misses nothing between the two */
export function listen(listener) {
  return new Promise((known) => {
    const ear = new SharedWorker(new URL("ear.js", import.meta.url));
    ear.onerror = () => known();
    ear.port.onmessage = (e) => {
      listener[/** @type {keyof Listener} */ (e.data.kind)](e.data.told);
      if (e.data.kind === "here") known();
    };
    addEventListener("pagehide", (e) => e.persisted || ear.port.postMessage("gone"));
  });
}
