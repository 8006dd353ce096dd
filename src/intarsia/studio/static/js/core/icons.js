/** Icons as paths on a grid of 16 px, drawn with the colour of the text. */

const PATHS = {
  add: "M8 3v10M3 8h10",
  again: "M13 8a5 5 0 1 1-1.500-3.600M13 2.500V5h-2.500",
  close: "M4 4l8 8M12 4l-8 8",
  compare: "M8 2v12M3 4.500h3v7H3zM10 4.500h3v7h-3z",
  copy: "M5.500 5.500h7v7h-7zM3.500 10.500v-7h7",
  crop: "M4.500 1.500v10h10M1.500 4.500h10v10",
  dark: "M8 2.500a5.500 5.500 0 0 0 0 11zM8 2.500a5.500 5.500 0 0 1 0 11",
  dice: "M3 3h10v10H3zM6 6h.01M10 6h.01M8 8h.01M6 10h.01M10 10h.01",
  down: "M8 2.500v8M4.500 7.500L8 11l3.500-3.500M3 13.500h10",
  erase: "M6 13.500h7M9 3l4 4-6 6.500H5l-2.500-2.500z",
  fill: "M7 2.500l6 6-5 5-5.500-5.500zM2.500 8h10.500M14 11.500v1",
  bin: "M3 4.500h10M6 4.500v-2h4v2M4.500 4.500l.5 9h6l.5-9",
  brush: "M13.500 2.500L7 9M6.500 8.500c-2-.5-3.500 1-3 4.500 3 .5 5-1 4.500-3",
  hand: "M8 2.500v11M2.500 8h11M6.500 4L8 2.500 9.500 4M6.500 12L8 13.500 9.500 12M4 6.500L2.500 8 4 9.500M12 6.500L13.500 8 12 9.500",
  more: "M3 7.200a.8.8 0 1 0 .01 0zM8 7.200a.8.8 0 1 0 .01 0zM13 7.200a.8.8 0 1 0 .01 0z",
  onward: "M2.500 8h10M9 4.500L12.500 8L9 11.500",
  pencil: "M3 13l.5-3L11 2.500 13.500 5 6 12.500zM9.500 4L12 6.500",
  redo: "M10.500 3.500L13 6l-2.500 2.500M13 6H6.500a3.500 3.500 0 0 0 0 7H9",
  undo: "M5.500 3.500L3 6l2.500 2.500M3 6h6.500a3.500 3.500 0 0 1 0 7H7",
};

/** @typedef {keyof typeof PATHS} IconName */

/** @param {IconName} name @returns {SVGElement} */
export function icon(name) {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  const path = document.createElementNS(space, "path");
  const line = { fill: "none", stroke: "currentColor", "stroke-width": "1.4", "stroke-linecap": "round" };
  for (const [key, value] of Object.entries({ ...line, "stroke-linejoin": "round", d: PATHS[name] })) {
    path.setAttribute(key, value);
  }
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  svg.append(path);
  return svg;
}
