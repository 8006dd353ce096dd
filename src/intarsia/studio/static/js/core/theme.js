/** Light or dark: as the system has it, until the switch says otherwise; the choice is kept by the studio. */

import { kept } from "./kept.js";

const KEY = "intarsia-theme";

/** Show what was chosen before: at once as this browser knows it, and once it is heard as the studio does. */
export function begin() {
  const theme = kept.of().theme ?? localStorage.getItem(KEY);
  if (theme) document.documentElement.dataset.theme = theme;
}

/** @returns {"light" | "dark"} */
export function now() {
  const set = document.documentElement.dataset.theme;
  if (set === "light" || set === "dark") return set;
  return matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark";
}

/** Change to the other one. */
export function turn() {
  const next = now() === "light" ? "dark" : "light";
  document.documentElement.dataset.theme = next;
  localStorage.setItem(KEY, next);
  kept.set({ theme: next });
}
