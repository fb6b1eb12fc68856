/** A chart's axes: their look, their labels, and round ticks where they are logarithmic. */
import { themeColour } from "../parts/palette.js";
import { tick } from "../texts/format.js";

const POWERS = Array.from({ length: 60 }, (_, i) => 10 ** (29 - i));
const ROUND = [1, 5, 2].flatMap((digit) => POWERS.map((power) => digit * power));

/**
 * uPlot's own ticks on a linear axis; round ones, so many pixels apart, on a logarithmic one.
 *
 * @param {string} scale
 * @param {boolean} isLog
 * @param {number} spacing
 * @returns {Pick<import("uplot").Axis, "splits" | "filter">}
 */
export function ticks(scale, isLog, spacing) {
  if (!isLog) return {};
  return {
    splits: (plot, _axis, min, max) =>
      roundTicks(min, max, (value) => plot.valToPos(value, scale), spacing),
    filter: (_, splits) => splits,
  };
}

/**
 * @param {string} label
 * @param {import("uplot").Axis["size"]} size
 * @returns {import("uplot").Axis}
 */
export function axis(label, size) {
  return {
    label,
    size,
    labelSize: 18,
    labelGap: 0,
    gap: 6,
    font: canvasFont(),
    labelFont: canvasFont(),
    stroke: () => themeColour("chart-text"),
    grid: { stroke: () => themeColour("chart-grid"), width: 1 },
    ticks: { show: false },
    border: { show: true, stroke: () => themeColour("chart-axis"), width: 1 },
    values: (_, splits) => splits.map((value) => (value === null ? "" : tick(value))),
  };
}

/** @returns {string} */
export function canvasFont() {
  return `11px ${getComputedStyle(document.body).fontFamily}`;
}

/**
 * Room for the widest label of the y axis.
 *
 * @param {import("uplot")} plot
 * @param {string[] | null} values
 * @returns {number}
 */
export function labelWidth(plot, values) {
  if (values === null) return 30;
  plot.ctx.save();
  plot.ctx.font = canvasFont();
  const widest = Math.max(...values.map((text) => plot.ctx.measureText(text).width));
  plot.ctx.restore();
  return Math.ceil(widest) + 12;
}

/**
 * 0 and +-(1, 5, 2) 10^k within [min, max]; powers of ten first, large ones first.
 *
 * @param {number} min
 * @param {number} max
 * @param {(value: number) => number} position a value’s place on the axis, in pixels
 * @param {number} spacing pixels between two ticks, at least
 * @returns {number[]}
 */
export function roundTicks(min, max, position, spacing) {
  const chosen = [];
  for (const value of [...ROUND.flatMap((size) => [size, -size]), 0]) {
    if (value < min || value > max) continue;
    const distances = chosen.map((other) => Math.abs(position(other) - position(value)));
    if (distances.every((distance) => distance >= spacing)) chosen.push(value);
  }
  return chosen.toSorted((a, b) => a - b);
}
