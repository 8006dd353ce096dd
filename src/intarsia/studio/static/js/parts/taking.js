/** What is taken away can be brought back for ten seconds: all that went one after another, at once. */

import { store } from "../core/store.js";
import { OFFERED, offer, tried } from "../core/toast.js";

/** @type {["jobs" | "exemplars", string][]} what can be brought back now */
let taken = [];
let timer = 0;

/** @param {"jobs" | "exemplars"} kind @param {...string} ids */
export async function takeAway(kind, ...ids) {
  await tried(async () => {
    for (const id of ids) {
      await store.takeAway(kind, id);
      taken.push([kind, id]);
    }
    const these = taken;
    const back = () => {
      taken = [];
      void tried(() => Promise.all(these.map((each) => store.bringBack(...each))));
    };
    offer(these.length > 1 ? `${these.length} deleted` : "Deleted", back);
    clearTimeout(timer);
    timer = window.setTimeout(() => (taken = []), OFFERED);
  });
}
