/** Light or dark: as the system has it, until the switch says otherwise; the choice is kept on this machine. */

const KEY = "intarsia-theme";

/** Show what was chosen before. */
export function begin() {
  const kept = localStorage.getItem(KEY);
  if (kept) document.documentElement.dataset.theme = kept;
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
}
