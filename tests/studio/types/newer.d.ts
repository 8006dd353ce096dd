// What browsers have and the TypeScript of Debian 12 (4.8) does not know yet.

declare class OffscreenCanvas extends EventTarget {
  constructor(width: number, height: number);
  width: number;
  height: number;
  getContext(kind: "2d", how?: CanvasRenderingContext2DSettings): CanvasRenderingContext2D | null;
}

interface CanvasDrawImage {
  drawImage(image: OffscreenCanvas, x: number, y: number): void;
  drawImage(image: OffscreenCanvas, x: number, y: number, width: number, height: number): void;
  drawImage(image: CanvasImageSource | OffscreenCanvas, x: number, y: number): void;
  drawImage(image: CanvasImageSource | OffscreenCanvas, x: number, y: number, width: number, height: number): void;
}

declare class CompressionStream implements ReadableWritablePair<Uint8Array, Uint8Array> {
  constructor(format: "gzip" | "deflate" | "deflate-raw");
  readonly readable: ReadableStream<Uint8Array>;
  readonly writable: WritableStream<Uint8Array>;
}
