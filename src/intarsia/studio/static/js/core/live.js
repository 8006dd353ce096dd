/** What the server tells by itself: jobs as they change, previews, and how warm it is. */

/**
 * @typedef {object} Listener
 * @property {(told: {done: number, total: number}) => void} warm
 * @property {(job: import("./types.js").Job) => void} job
 * @property {(told: {id: string, number: number}) => void} preview
 * @property {(here: boolean) => void} here whether the server is heard; true again after it was away
 */

/**
 * Listen for as long as the page is open; the browser connects again by itself.
 * @param {Listener} listener
 * @returns {EventSource}
 */
export function listen(listener) {
  const source = new EventSource("/api/events");
  const heard = /** @param {(told: any) => void} tell */ (tell) => (/** @type {MessageEvent} */ e) => {
    tell(JSON.parse(e.data));
  };
  source.addEventListener("warm", heard(listener.warm));
  source.addEventListener("job", heard(listener.job));
  source.addEventListener("preview", heard(listener.preview));
  source.addEventListener("open", () => listener.here(true));
  source.addEventListener("error", () => listener.here(false));
  return source;
}
