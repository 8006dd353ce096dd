/** Draws a material under a lamp with WebGL 2, flat or on a solid, as large as the stage and as it is zoomed, moved and tiled. */

import { CORNERS, SHAPES, SOLID, SURFACE } from "./shaders.js";

/** @typedef {{x: number, y: number, height: number, power: number}} Lamp x, y: shares of the stage; height: of its shorter side */
/** @typedef {{shape: typeof SHAPES[number], turn: number, tilt: number, relief: number}} Pose
 *   turn, tilt: degrees; relief: share of the shorter side of the picture that white of the height stands for */
/** @typedef {Partial<Record<MapName, ImageBitmap>>} Maps */
/** @typedef {typeof MAPS[number]["name"]} MapName */

/** What the surface is made of, in the order of texture units; and what stands for a map that is not there. */
export const MAPS = /** @type {const} */ ([
  { name: "albedo", instead: [188, 188, 188, 255] },
  { name: "normal", instead: [128, 128, 255, 255] },
  { name: "roughness", instead: [166, 166, 166, 255] },
  { name: "metallic", instead: [0, 0, 0, 255] },
  { name: "ao", instead: [255, 255, 255, 255] },
  { name: "height", instead: [128, 128, 128, 255] },
]);

export class Renderer {
  canvas = document.createElement("canvas");
  /** @type {WebGLTexture[]} */ #textures = [];
  /** @type {WebGLProgram | null} that draws solids, made when one is first asked for */
  #solid = null;
  /** @type {Maps} */ #maps = {};
  #up = 1;

  /** @param {WebGL2RenderingContext} gl @param {WebGLProgram} flat @param {HTMLCanvasElement} canvas */
  constructor(gl, flat, canvas) {
    this.gl = gl;
    this.flat = flat;
    this.canvas = canvas;
    gl.bindVertexArray(gl.createVertexArray());
  }

  /** @returns {Renderer | null} null where there is no WebGL 2 */
  static begin() {
    const canvas = document.createElement("canvas");
    const gl = canvas.getContext("webgl2", { alpha: true, antialias: false, depth: false, powerPreference: "low-power" });
    const flat = gl && linked(gl, SURFACE);
    return gl && flat ? new Renderer(gl, flat, canvas) : null;
  }

  /** Take another material.
   * @param {Maps} maps @param {boolean} down whether green of its normals points down the picture */
  take(maps, down) {
    const { gl } = this;
    for (const texture of this.#textures) gl.deleteTexture(texture);
    this.#textures = MAPS.map(({ name, instead }, unit) => this.#texture(unit, name, maps[name], instead));
    this.#maps = maps;
    this.#up = down ? -1 : 1;
  }

  /** Draw it.
   * @param {{width: number, height: number}} stage px of the device @param {{x: number, y: number, scale: number}} view
   * @param {{width: number, height: number}} size of the picture @param {number} tiles along each axis
   * @param {Lamp} lamp @param {Pose} pose @returns {HTMLCanvasElement} */
  draw(stage, view, size, tiles, lamp, pose) {
    const { gl, canvas } = this;
    const { height, normal } = this.#maps;
    const solid = pose.shape !== "flat" && (this.#solid ??= linked(gl, SOLID));
    const program = solid || this.flat;
    const at = (/** @type {string} */ name) => gl.getUniformLocation(program, name);
    gl.useProgram(program);
    if (canvas.width !== stage.width) canvas.width = stage.width;
    if (canvas.height !== stage.height) canvas.height = stage.height;
    gl.viewport(0, 0, stage.width, stage.height);
    MAPS.forEach(({ name }, unit) => {
      gl.uniform1i(at(name), unit);
      gl.activeTexture(gl.TEXTURE0 + unit);
      const border = tiles > 1 || solid ? gl.REPEAT : gl.CLAMP_TO_EDGE;
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, border);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, border);
    });
    gl.uniform2f(at("corner"), view.x, view.y);
    const extent = [size.width * view.scale, size.height * view.scale].map((side) => (solid ? side * tiles : side));
    gl.uniform2fv(at("extent"), extent);
    gl.uniform1f(at("tiles"), tiles);
    gl.uniform1f(at("tall"), stage.height);
    const above = lamp.height * Math.min(stage.width, stage.height);
    gl.uniform3f(at("lamp"), lamp.x * stage.width, lamp.y * stage.height, above);
    gl.uniform1f(at("power"), lamp.power);
    gl.uniform1f(at("up"), this.#up);
    gl.uniform1f(at("relief"), height && !normal ? pose.relief * Math.min(height.width, height.height) : 0);
    if (solid) {
      gl.uniform1i(at("shape"), SHAPES.indexOf(pose.shape));
      gl.uniformMatrix3fv(at("turn"), false, turned(pose));
      gl.uniform1f(at("depth"), height ? (1.4 * pose.relief) / tiles : 0); // about 1.4 radii are one tile
    }
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    return canvas;
  }

  /** A map as a texture; colours are sRGB, all else are numbers.
   * @param {number} unit @param {MapName} name @param {ImageBitmap | undefined} picture
   * @param {readonly number[]} instead @returns {WebGLTexture} */
  #texture(unit, name, picture, instead) {
    const { gl } = this;
    const texture = /** @type {WebGLTexture} */ (gl.createTexture());
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    const kept = name === "albedo" ? gl.SRGB8_ALPHA8 : gl.RGBA8;
    if (picture) gl.texImage2D(gl.TEXTURE_2D, 0, kept, gl.RGBA, gl.UNSIGNED_BYTE, picture);
    else gl.texImage2D(gl.TEXTURE_2D, 0, kept, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(instead));
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    return texture;
  }
}

/** The matrix from the eye's directions to those of a solid that is tilted and turned, column by column.
 * @param {Pose} pose */
function turned(pose) {
  const [a, b] = [(Math.PI * pose.turn) / 180, (Math.PI * pose.tilt) / 180];
  const [ca, sa, cb, sb] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b)];
  return [ca, 0, -sa, -sa * sb, cb, -ca * sb, sa * cb, sb, ca * cb];
}

/** @param {WebGL2RenderingContext} gl @param {string} surface @returns {WebGLProgram | null} */
function linked(gl, surface) {
  const program = gl.createProgram();
  if (!program) return null;
  for (const [kind, text] of /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, CORNERS], [gl.FRAGMENT_SHADER, surface]])) {
    const shader = gl.createShader(kind);
    if (!shader) return null;
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  return gl.getProgramParameter(program, gl.LINK_STATUS) ? program : null;
}
