/** An estimate with its interval, drawn on a scale that rows of a table share. */
import { shape } from "../parts/element.js";

/** @typedef {{ value: number, low: number | null, high: number | null }} Estimate */

const WIDTH = 300;
const HEIGHT = 20;

/**
 * A scale over all estimates and some marked values: value -> 0 to 1.
 *
 * @param {Estimate[]} estimates
 * @param {number[]} marks
 * @returns {(value: number) => number}
 */
export function scaleOf(estimates, marks) {
  const values = estimates.flatMap(({ value, low, high }) => [value, low ?? value, high ?? value]);
  const low = Math.min(...values, ...marks);
  const span = Math.max(...values, ...marks) - low || 1;
  return (value) => 0.02 + (0.96 * (value - low)) / span;
}

/**
 * @param {Estimate} estimate
 * @param {string} colour
 * @param {(value: number) => number} scale
 * @param {number[]} marks values to compare with, as hairlines
 * @returns {SVGSVGElement}
 */
export function interval({ value, low, high }, colour, scale, marks) {
  const picture = shape("svg", {
    "viewBox": `0 0 ${WIDTH} ${HEIGHT}`,
    "preserveAspectRatio": "none",
    "class": "interval",
    "aria-hidden": "true",
  });
  const x = (/** @type {number} */ number) => WIDTH * scale(number);
  for (const mark of marks) {
    picture.append(shape("line", { class: "unit", x1: x(mark), x2: x(mark), y1: 0, y2: HEIGHT }));
  }
  const middle = HEIGHT / 2;
  if (low !== null && high !== null) {
    picture.append(shape("line", { x1: x(low), x2: x(high), y1: middle, y2: middle, stroke: colour }));
  }
  const dot = { x1: x(value), x2: x(value), y1: middle - 6, y2: middle + 6, stroke: colour };
  picture.append(shape("line", dot));
  return picture;
}
