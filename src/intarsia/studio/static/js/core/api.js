/** What the server is asked: one function for each way of asking, and errors in the server's own line. */

/** @typedef {import("./types.js").Exemplar} Exemplar */

/** What the server refused; the message is its line. */
export class Refused extends Error {
  /** @param {string} line @param {number} status */
  constructor(line, status) {
    super(line);
    this.status = status;
  }
}

/** @param {string} path @param {RequestInit} [how] @returns {Promise<Response>} */
async function ask(path, how = {}) {
  const headers = { "X-Intarsia": "1", ...(how.headers ?? {}) };
  let answer;
  try {
    answer = await fetch(path, { credentials: "same-origin", ...how, headers });
  } catch (error) {
    if (how.signal?.aborted) throw error;
    throw new Refused("The studio does not answer; is `intarsia studio` still running?", 0);
  }
  if (answer.ok) return answer;
  let line = `The studio answered ${answer.status}.`;
  try {
    line = (await answer.json()).error ?? line;
  } catch {
    // not JSON: the line above must do
  }
  throw new Refused(line, answer.status);
}

/** @param {string} path @returns {Promise<any>} */
export async function get(path) {
  return (await ask(path)).json();
}

/** @param {string} path @param {unknown} [body] JSON, or a form, or bytes @returns {Promise<any>} */
export async function post(path, body = {}) {
  const plain = body instanceof FormData || body instanceof Blob;
  /** @type {Record<string, string>} */ const headers = plain ? {} : { "Content-Type": "application/json" };
  const answer = await ask(path, { method: "POST", body: plain ? body : JSON.stringify(body), headers });
  return answer.status === 204 ? null : answer.json();
}

/** @param {string} path */
export async function remove(path) {
  await ask(path, { method: "DELETE" });
}

/** A picture, decoded off the main thread. Its numbers stay as they are stored.
 * @param {string} path @param {AbortSignal} [signal] @param {unknown} [said] JSON that is sent @returns {Promise<ImageBitmap>} */
export async function picture(path, signal, said) {
  const sent = said ? { method: "POST", body: JSON.stringify(said), headers: { "Content-Type": "application/json" } } : {};
  const answer = await ask(path, { signal, ...sent });
  if (answer.status === 204) throw new Refused("There is no picture of this now.", 204);
  return createImageBitmap(await answer.blob(), { colorSpaceConversion: "none", premultiplyAlpha: "default" });
}

/** The numbers of a picture of one channel and 8 bits.
 * @param {string} path @returns {Promise<{width: number, height: number, data: Uint8Array}>} row by row */
export async function numbers(path) {
  const drawn = await picture(path);
  const pen = new OffscreenCanvas(drawn.width, drawn.height).getContext("2d");
  if (!pen) throw new Error("This browser draws nothing.");
  pen.drawImage(drawn, 0, 0);
  const pixels = pen.getImageData(0, 0, drawn.width, drawn.height).data;
  const data = Uint8Array.from({ length: pixels.length / 4 }, (_, n) => pixels[4 * n] ?? 0);
  return { width: drawn.width, height: drawn.height, data };
}

/** @param {string} path @returns {Promise<ArrayBuffer>} */
export async function bytes(path) {
  return (await ask(path)).arrayBuffer();
}

/** Where the pixels of a part of a result come from.
 * @param {string} result @param {string} box x, y, width, height
 * @returns {Promise<{size: string, numbers: Uint16Array}>} size of the whole map; exemplar, row and column of each pixel */
export async function originsOf(result, box) {
  const answer = await ask(`/api/results/${result}/map.bin?box=${box}`);
  return { size: answer.headers.get("X-Size") ?? "", numbers: new Uint16Array(await answer.arrayBuffer()) };
}

/** The longest side of a picture that the server makes for a page. */
export const LONGEST = 4096;

/** Where a reduced picture of an exemplar lies.
 * @param {Exemplar} exemplar @param {number} [side] @param {string} [plane] */
export function viewOf(exemplar, side = LONGEST, plane) {
  const at = exemplar.planes.find((p) => p.name === plane) ?? exemplar.planes[0];
  return `/api/exemplars/${exemplar.id}/${at?.name}.png?side=${side}`;
}

/** Where a file of a result lies.
 * @param {import("./types.js").Result} result @param {string} name */
export function fileOf(result, name) {
  return `/api/results/${result.id}/files/${name}`;
}

/** Where a view of a result lies: a plane, pieces, seams, usage, ...
 * @param {string} result @param {string} kind @param {number} [side] */
export function lookOf(result, kind, side = LONGEST) {
  return `/api/results/${result}/view/${kind}.png?side=${side}`;
}

/** What healing would add to a hole so that a rim of the defect goes, too.
 * @param {Exemplar} exemplar @param {string} image of the hole @returns {Promise<{grow: number, drawn: ImageBitmap}>} */
export async function rimOf(exemplar, image) {
  const answer = await ask(`/api/exemplars/${exemplar.id}/rim/${image}.png`);
  return { grow: Number(answer.headers.get("X-Grow")), drawn: await createImageBitmap(await answer.blob()) };
}

/** What a method makes of an exemplar, small; null where it cannot serve it.
 * @param {Exemplar} exemplar @param {string} method @param {AbortSignal} signal @returns {Promise<HTMLImageElement | null>} */
export async function sketchOf(exemplar, method, signal) {
  const path = `/api/exemplars/${exemplar.id}/methods/${method}.png`;
  const answer = await ask(path, { signal });
  if (answer.status === 204) return null;
  const image = new Image();
  image.alt = "";
  image.src = path; // it is kept by the browser now
  await image.decode();
  return image;
}
