/** Draws a material under a lamp with WebGL 2, as large as the stage and as the stage is zoomed, moved and tiled. */

import { CORNERS, SURFACE } from "./shaders.js";

/** @typedef {{x: number, y: number, height: number, power: number}} Lamp x, y: shares of the stage; height: of its shorter side */
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

/** Share of the shorter side that white of a height stands for; files do not say it. */
const RELIEF = 0.06;

export class Renderer {
  canvas = document.createElement("canvas");
  /** @type {Record<string, WebGLUniformLocation | null>} */
  #places = {};
  /** @type {WebGLTexture[]} */
  #textures = [];
  #relief = 0;
  #up = 1;

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {WebGLProgram} program
   * @param {HTMLCanvasElement} canvas
   */
  constructor(gl, program, canvas) {
    this.gl = gl;
    this.canvas = canvas;
    gl.useProgram(program);
    gl.bindVertexArray(gl.createVertexArray());
    for (const name of ["corner", "extent", "tiles", "tall", "lamp", "power", "up", "relief", ...MAPS.map((map) => map.name)]) {
      this.#places[name] = gl.getUniformLocation(program, name);
    }
    MAPS.forEach(({ name }, unit) => gl.uniform1i(this.#at(name), unit));
  }

  /** @returns {Renderer | null} null where there is no WebGL 2 */
  static begin() {
    const canvas = document.createElement("canvas");
    const gl = canvas.getContext("webgl2", { alpha: true, antialias: false, depth: false, powerPreference: "low-power" });
    const program = gl && linked(gl);
    return gl && program ? new Renderer(gl, program, canvas) : null;
  }

  /**
   * Take another material.
   * @param {Maps} maps
   * @param {boolean} down whether green of its normals points down the picture
   */
  take(maps, down) {
    const { gl } = this;
    for (const texture of this.#textures) gl.deleteTexture(texture);
    this.#textures = MAPS.map(({ name, instead }, unit) => this.#texture(unit, name, maps[name], instead));
    const { height, normal } = maps;
    this.#relief = height && !normal ? RELIEF * Math.min(height.width, height.height) : 0;
    this.#up = down ? -1 : 1;
  }

  /**
   * Draw it.
   * @param {{width: number, height: number}} stage px of the device
   * @param {import("../stage/view.js").View} view
   * @param {{width: number, height: number}} size of the picture
   * @param {number} tiles along each axis
   * @param {Lamp} lamp
   * @returns {HTMLCanvasElement}
   */
  draw(stage, view, size, tiles, lamp) {
    const { gl, canvas } = this;
    if (canvas.width !== stage.width) canvas.width = stage.width;
    if (canvas.height !== stage.height) canvas.height = stage.height;
    gl.viewport(0, 0, stage.width, stage.height);
    MAPS.forEach((_, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      const border = tiles > 1 ? gl.REPEAT : gl.CLAMP_TO_EDGE;
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, border);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, border);
    });
    gl.uniform2f(this.#at("corner"), view.x, view.y);
    gl.uniform2f(this.#at("extent"), size.width * view.scale, size.height * view.scale);
    gl.uniform1f(this.#at("tiles"), tiles);
    gl.uniform1f(this.#at("tall"), stage.height);
    const above = lamp.height * Math.min(stage.width, stage.height);
    gl.uniform3f(this.#at("lamp"), lamp.x * stage.width, lamp.y * stage.height, above);
    gl.uniform1f(this.#at("power"), lamp.power);
    gl.uniform1f(this.#at("up"), this.#up);
    gl.uniform1f(this.#at("relief"), this.#relief);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    return canvas;
  }

  /** @param {string} name */
  #at(name) {
    return this.#places[name] ?? null;
  }

  /**
   * A map as a texture; colours are sRGB, all else are numbers.
   * @param {number} unit
   * @param {MapName} name
   * @param {ImageBitmap | undefined} picture
   * @param {readonly number[]} instead
   * @returns {WebGLTexture}
   */
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

/**
 * @param {WebGL2RenderingContext} gl
 * @returns {WebGLProgram | null}
 */
function linked(gl) {
  const program = gl.createProgram();
  if (!program) return null;
  for (const [kind, text] of /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, CORNERS], [gl.FRAGMENT_SHADER, SURFACE]])) {
    const shader = gl.createShader(kind);
    if (!shader) return null;
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  return gl.getProgramParameter(program, gl.LINK_STATUS) ? program : null;
}
