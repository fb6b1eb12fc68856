/** A short piece of a curve's line, in its colour and dash. */

const SVG = "http://www.w3.org/2000/svg";

export function swatch({ colour, dash }) {
  const icon = document.createElementNS(SVG, "svg");
  const line = document.createElementNS(SVG, "line");
  const attributes = { x1: 0, y1: 4, x2: 26, y2: 4, stroke: colour, "stroke-width": 2.5 };
  for (const [name, value] of Object.entries(attributes)) line.setAttribute(name, value);
  if (dash.length > 0) line.setAttribute("stroke-dasharray", dash.join(" "));
  icon.setAttribute("viewBox", "0 0 26 8");
  icon.setAttribute("class", "swatch");
  icon.setAttribute("aria-hidden", "true");
  icon.append(line);
  return icon;
}
