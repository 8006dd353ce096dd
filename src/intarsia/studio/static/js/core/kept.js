/** What the studio keeps for its page, so that neither a reload nor a new start loses it: by exemplar, and for all of them. */

import { get, post } from "./api.js";

/** Where what is still to be sent waits, in case that the page goes before it is. */
const DUE = "intarsia-due";

class Kept {
  /** @type {Record<string, Record<string, any>>} */ #all = {};
  /** @type {Set<string>} what is still to be sent */
  #due = new Set();
  #sending = false;

  async load() {
    const due = JSON.parse(sessionStorage.getItem(DUE) ?? "{}");
    this.#all = await get("/api/kept");
    for (const [key, value] of Object.entries(due)) this.set(value, key);
  }

  /** @param {string} [key] id of an exemplar; by default for all of them @returns {Readonly<Record<string, any>>} */
  of(key = "page") {
    return this.#all[key] ?? {};
  }

  /** @param {Record<string, any>} change @param {string} [key] */
  set(change, key = "page") {
    this.#all[key] = { ...this.of(key), ...change };
    this.#due.add(key);
    this.#note();
    void this.send();
  }

  #note() {
    sessionStorage.setItem(DUE, JSON.stringify(Object.fromEntries([...this.#due].map((key) => [key, this.of(key)]))));
  }

  /** Send what is still to be sent. Where the studio is away it stays, until the next change or until it is heard again. */
  async send() {
    if (this.#sending) return;
    this.#sending = true;
    for (const key of this.#due) {
      const value = this.of(key);
      const refused = await post(`/api/kept/${key}`, value).then(() => null, (error) => error);
      if (refused && refused.status !== 404) continue; // which is said elsewhere; 404: the exemplar is gone
      this.#due.delete(key);
      if (this.of(key) !== value) this.#due.add(key); // it changed meanwhile
      this.#note();
    }
    this.#sending = false;
  }
}

export const kept = new Kept();
