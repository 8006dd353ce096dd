/** Label pictures and masks on their way to the server: the numbers themselves, and nothing else. */

import { post } from "../core/api.js";
import { png } from "./png.js";

/**
 * @param {import("./labels.js").Labels} labels
 * @param {(value: number) => number} [meaning] what is sent for a number; by default itself
 * @returns {Promise<string>} id of the image
 */
export async function send(labels, meaning) {
  const numbers = meaning ? labels.data.map(meaning) : labels.data;
  return (await post("/api/images", await png(numbers, labels.width, labels.height))).id;
}
