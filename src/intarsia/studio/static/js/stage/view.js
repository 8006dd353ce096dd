/** Where a picture lies on the stage: scale and place, as whole device pixels, and how they change. */

export class View {
  /** @type {number} device pixels a picture pixel */
  scale = 1;
  /** @type {number} device pixel of the picture's left border */
  x = 0;
  /** @type {number} */ y = 0;
  /** Whether it follows the size of the stage until somebody moves it. */
  fitted = true;

  /** Show all of it, in the middle; what is enlarged is so by a whole number if one is near, so that no pixel is smeared.
   * @param {number} width of the picture @param {number} height
   * @param {number} wide of the stage in device pixels @param {number} high @param {number} margin
   * @param {number} most scale, so that a small picture does not become blocks */
  fit(width, height, wide, high, margin, most) {
    const scale = Math.min((wide - 2 * margin) / width, (high - 2 * margin) / height);
    this.scale = Math.max(1e-3, Math.min(most, scale > 1 && scale / Math.floor(scale) < 1.25 ? Math.floor(scale) : scale));
    this.x = Math.round((wide - width * this.scale) / 2);
    this.y = Math.round((high - height * this.scale) / 2);
    this.fitted = true;
  }

  /** Change the scale so that what lies at (x, y) of the stage stays there.
   * @param {number} scale @param {number} x @param {number} y */
  zoom(scale, x, y) {
    const next = Math.max(1 / 64, Math.min(64, scale));
    const [u, v] = this.at(x, y);
    this.scale = next;
    this.x = x - u * next;
    this.y = y - v * next;
    this.fitted = false;
  }

  /** @param {number} dx device pixels @param {number} dy */
  move(dx, dy) {
    this.x += dx;
    this.y += dy;
    this.fitted = false;
  }

  /** The place in the picture that lies at a place of the stage.
   * @param {number} x device pixels @param {number} y @returns {[number, number]} */
  at(x, y) {
    return [(x - this.x) / this.scale, (y - this.y) / this.scale];
  }
}
