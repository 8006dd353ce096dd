/** How the stage is looked at: all of it, pixel for pixel, or three by three. */

import { button, el } from "../core/dom.js";

/** @param {import("../stage/stage.js").Stage} stage @param {boolean} [tiling] whether it may be repeated @returns {HTMLElement} */
export function viewButtons(stage, tiling = true) {
  const fit = button("Fit", () => stage.fit(), { title: "All of it (0)" });
  const whole = button("100 %", () => stage.whole(), { title: "Pixel for pixel (1)" });
  const tiles = button("3 × 3", () => [stage.tile(stage.tiles === 3 ? 1 : 3), show()], { title: "Repeated, to see whether it tiles" });
  const zoom = el("span", { class: "zoom quiet small number", "aria-label": "Zoom" });
  const show = () => {
    fit.setAttribute("aria-pressed", String(stage.view.fitted));
    whole.setAttribute("aria-pressed", String(stage.view.scale === 1 && !stage.view.fitted));
    tiles.setAttribute("aria-pressed", String(stage.tiles === 3));
    zoom.textContent = stage.draft || !stage.picture ? "" : `${Math.round(stage.view.scale * 100)} %`;
  };
  stage.addEventListener("view", show);
  show();
  return el("div", { class: "view-buttons" }, el("div", { class: "segments" }, fit, whole), tiling && el("div", { class: "segments" }, tiles), zoom);
}
