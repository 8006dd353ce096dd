/** What labels look like: of each the largest square that is marked with it alone, mirrored so that no seam shows. */

/** @typedef {import("./labels.js").Ink} Ink */

const STEPS = 256; // along the longer side, in which squares are looked for
const MOST = 512; // px a side

/**
 * @param {import("./labels.js").Labels} labels over a picture
 * @param {ImageBitmap} picture it may be reduced
 * @returns {(Ink | undefined)[]} by label; those that are marked nowhere have none
 */
export function textures({ width, height, data }, picture) {
  const step = Math.ceil(Math.max(width, height) / STEPS);
  const wide = Math.floor(width / step);
  const few = new Uint8Array(wide * Math.floor(height / step));
  const sides = new Uint16Array(few.length); // of the square of one label whose last corner is here
  /** @type {{side: number, at: number}[]} */
  const best = [];
  for (let at = 0; at < few.length; at += 1) {
    const label = (few[at] = data[Math.floor(at / wide) * step * width + (at % wide) * step] ?? 0);
    const [left, above, both] = [at - 1, at - wide, at - wide - 1];
    const inside = at % wide && at >= wide && few[left] === label && few[above] === label && few[both] === label;
    const side = 1 + (inside ? Math.min(sides[left] ?? 0, sides[above] ?? 0, sides[both] ?? 0) : 0);
    sides[at] = side;
    if (side > (best[label]?.side ?? 0)) best[label] = { side, at };
  }
  return best.map(({ side, at }) => {
    const [x, y] = [(at % wide) + 1 - side, Math.floor(at / wide) + 1 - side];
    return mirrored(picture, x * step, y * step, Math.min(MOST, side * step), picture.width / width);
  });
}

/** @param {ImageBitmap} picture @param {number} x @param {number} y @param {number} side @param {number} scale of the picture @returns {Ink | undefined} */
function mirrored(picture, x, y, side, scale) {
  const pen = new OffscreenCanvas(2 * side, 2 * side).getContext("2d", { willReadFrequently: true });
  if (!pen) return undefined;
  for (const across of [1, -1]) {
    for (const down of [1, -1]) {
      pen.setTransform(across, 0, 0, down, across < 0 ? 2 * side : 0, down < 0 ? 2 * side : 0);
      pen.drawImage(picture, x * scale, y * scale, side * scale, side * scale, 0, 0, side, side);
    }
  }
  return { side: 2 * side, pixels: new Uint32Array(pen.getImageData(0, 0, 2 * side, 2 * side).data.buffer) };
}
