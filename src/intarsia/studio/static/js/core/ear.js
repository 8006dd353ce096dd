/**
 * A worker that all pages of this browser share: it alone listens to the server, and hands on what it hears. A browser has
 * six connections to a server, so pages that each listened would soon have none left for anything else.
 */

const KINDS = ["warm", "job", "preview", "exemplar", "gone"];
const AGAIN = 3000; // ms until a server is asked again that refused to be listened to
/** @type {Set<MessagePort>} one for each page, which loses nothing that is said before the page listens */
const pages = new Set();
/** @type {Map<string, unknown>} how things are, for a page that comes later */
const now = new Map();

function listen() {
  const ear = new EventSource("/api/events");
  for (const kind of KINDS) ear.addEventListener(kind, (e) => tell(kind, JSON.parse(/** @type {MessageEvent} */ (e).data)));
  ear.addEventListener("open", () => tell("here", true));
  ear.addEventListener("error", () => {
    tell("here", false);
    if (ear.readyState === EventSource.CLOSED) setTimeout(listen, AGAIN);
  });
}

/** @param {string} kind @param {unknown} told */
function tell(kind, told) {
  if (kind === "warm" || kind === "here") now.set(kind, told);
  for (const page of pages) page.postMessage({ kind, told });
}

listen();
self.addEventListener("connect", (e) => {
  const page = /** @type {MessagePort} */ (/** @type {MessageEvent} */ (e).ports[0]);
  page.onmessage = () => pages.delete(page); // it says nothing but that it goes
  pages.add(page);
  for (const [kind, told] of now) page.postMessage({ kind, told });
});
