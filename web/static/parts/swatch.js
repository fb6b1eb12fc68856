import { shape } from "./element.js";

/**
 * A short piece of a curve's line, in its colour and dash.
 *
 * @param {{ colour: string, dash: number[] }} identity
 * @returns {SVGSVGElement}
 */
export function swatch({ colour, dash }) {
  const line = shape("line", { x1: 0, y1: 4, x2: 26, y2: 4, stroke: colour });
  line.setAttribute("stroke-width", "2.5");
  if (dash.length > 0) line.setAttribute("stroke-dasharray", dash.join(" "));
  return shape("svg", { "viewBox": "0 0 26 8", "class": "swatch", "aria-hidden": "true" }, line);
}
