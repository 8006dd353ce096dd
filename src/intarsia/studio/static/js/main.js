/** Begin: the look, the shell, what the server has, and then listening to it. */

import { listen } from "./core/live.js";
import { kept } from "./core/kept.js";
import { restore } from "./core/settings.js";
import { store } from "./core/store.js";
import { begin } from "./core/theme.js";
import { tried } from "./core/toast.js";
import "./shell.js";

begin();
let away = false;
const listening = listen({
  warm: (told) => {
    store.warm = told;
    store.tell("warm");
  },
  job: (job) => store.note(job),
  exemplar: (exemplar) => store.opened(exemplar),
  preview: (told) => store.seen(told.id, told.number),
  gone: (told) => store.gone(told.job ?? told.exemplar ?? ""),
  here: (here) => {
    if (here && away) void tried(() => Promise.all([arrive(), kept.send()]));
    away = !here;
    store.here = here;
    store.tell("here");
  },
});
await tried(arrive);

/** What the page keeps comes before all else: without it nobody knows which exemplar is worked with. */
async function arrive() {
  if (!store.loaded) {
    await kept.load();
    begin();
    restore();
    await listening;
  }
  await store.load();
}
