/** What labels look like: of each the largest square that is marked with it alone, made to repeat without a seam. */

const STEPS = 256; // along the longer side, in which squares are looked for
const MOST = 512; // px a side

/** @param {import("./labels.js").Labels} labels over a picture @param {ImageBitmap} picture it may be reduced
 * @returns {(import("./labels.js").Ink | undefined)[]} by label; those that are marked nowhere have none */
export function textures({ width, height, data }, picture) {
  const step = Math.ceil(Math.max(width, height) / STEPS);
  const wide = Math.floor(width / step);
  const few = new Uint8Array(wide * Math.floor(height / step));
  const sides = new Uint16Array(few.length); // of the square of one label whose last corner is here
  /** @type {{side: number, at: number}[]} */ const best = [];
  for (let at = 0; at < few.length; at += 1) {
    const label = (few[at] = data[Math.floor(at / wide) * step * width + (at % wide) * step] ?? 0);
    const before = [at - 1, at - wide, at - wide - 1];
    const inside = at % wide && before.every((one) => few[one] === label);
    const side = (sides[at] = inside ? 1 + Math.min(...before.map((one) => sides[one] ?? 0)) : 1);
    if (side > (best[label]?.side ?? 0)) best[label] = { side, at };
  }
  return best.map(({ side, at }) => {
    const place = [(at % wide) + 1 - side, Math.floor(at / wide) + 1 - side].map((n) => (n * step * picture.width) / width);
    return repeating(picture, place, Math.min(MOST, side * step), picture.width / width);
  });
}

/** A square of which the last quarter fades into the first, along both axes.
 * @param {ImageBitmap} picture @param {number[]} place @param {number} side @param {number} scale of the picture */
function repeating(picture, [x = 0, y = 0], side, scale) {
  const pen = new OffscreenCanvas(side, side).getContext("2d", { willReadFrequently: true });
  if (!pen) return undefined;
  const fade = side >> 2;
  const once = side - fade;
  pen.drawImage(picture, x, y, side * scale, side * scale, 0, 0, side, side);
  for (let n = 0; n < 2 * fade; n += 1) {
    const line = n % fade;
    pen.globalAlpha = 1 - (line + 0.5) / fade;
    if (n < fade) pen.drawImage(pen.canvas, once + line, 0, 1, side, line, 0, 1, side);
    else pen.drawImage(pen.canvas, 0, once + line, side, 1, 0, line, side, 1);
  }
  return { side: once, pixels: new Uint32Array(pen.getImageData(0, 0, once, once).data.buffer) };
}
