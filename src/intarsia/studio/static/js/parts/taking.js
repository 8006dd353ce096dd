/** What is taken away can be brought back for ten seconds: all that went one after another, at once. */

import { button } from "../core/dom.js";
import { store } from "../core/store.js";
import { OFFERED, offer, tried } from "../core/toast.js";

/** @type {["jobs" | "exemplars", string][]} what the last offer brings back */ let taken = [];
/** @type {["jobs" | "exemplars", string][]} all that can be brought back, until the page goes */ let gone = [];
let timer = 0;

/** @param {["jobs" | "exemplars", string][]} these */
async function bringBack(these) {
  await tried(() => Promise.all(these.map((each) => store.bringBack(...each))));
  gone = gone.filter((each) => !these.includes(each));
  taken = taken.filter((each) => !these.includes(each));
  store.tell("jobs");
}

/** A button that brings back all that was taken away, if anything was. */
export function bringing() {
  const all = gone;
  return all.length > 0 && button(`Bring back ${all.length} deleted`, () => void bringBack(all), { class: "framed" });
}

/** @param {"jobs" | "exemplars"} kind @param {...string} ids */
export async function takeAway(kind, ...ids) {
  await tried(async () => {
    for (const id of ids) {
      await store.takeAway(kind, id);
      taken = [...taken, [kind, id]];
      gone = [...gone, ...taken.slice(-1)];
    }
    const these = taken;
    offer(these.length > 1 ? `${these.length} deleted` : "Deleted", () => void bringBack(these));
    store.tell("jobs");
    clearTimeout(timer);
    timer = window.setTimeout(() => (taken = []), OFFERED);
  });
}
