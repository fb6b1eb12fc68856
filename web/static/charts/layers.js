/** Curves as uPlot's columns and series, on the union of the steps that they were measured at. */
import { faint } from "../parts/palette.js";

/**
 * @typedef {import("uplot").Series} Series
 * @typedef {(number | null)[]} Column
 *
 * @typedef {object} Curve
 * @property {string} label
 * @property {string} colour
 * @property {number[]} dash
 * @property {number[]} x
 * @property {Column} line   what is drawn boldly
 * @property {Column} mean   what is read at the cursor, with `n`
 * @property {number[]} n    how many seeds it is the mean of
 * @property {Column} [low]   the band, absent when none is shown
 * @property {Column} [high]
 * @property {Column} [raw]   drawn faintly behind a smoothed line
 * @property {Column[]} [seeds]   thin single lines
 */

const BAND_OPACITY = 0.16;
const FAINT_OPACITY = 0.35;
const SEED_OPACITY = 0.3;
const LINE_WIDTH = 2;

/**
 * uPlot's columns [x, ...series], in the order of `layers`, on the union of the curves' steps.
 *
 * @param {Curve[]} curves
 * @returns {import("uplot").AlignedData}
 */
export function align(curves) {
  const xs = union(curves.map((curve) => curve.x));
  const onto = curves.map((curve) => placement(curve.x, xs));
  const each = (/** @type {Layer["columns"]} */ pick) =>
    curves.flatMap((curve, i) => pick(curve).map((column) => onto[i](column)));
  return [xs, ...LAYERS.flatMap(({ columns }) => each(columns))];
}

/**
 * A layer takes some columns of every curve.
 *
 * @typedef {object} Layer
 * @property {(curve: Curve) => Column[]} columns
 * @property {(curve: Curve) => Series} style
 */

/**
 * What is drawn, back to front.
 *
 * @type {Layer[]}
 */
const LAYERS = [
  {
    columns: ({ low, high }) => (low && high ? [high, low] : []),
    style: () => ({ points: { show: false } }),
  },
  {
    columns: (curve) => curve.seeds ?? [],
    style: ({ colour }) => ({ stroke: faint(colour, SEED_OPACITY), width: 1, ...noPoints }),
  },
  {
    columns: (curve) => (curve.raw ? [curve.raw] : []),
    style: ({ colour }) => ({ stroke: faint(colour, FAINT_OPACITY), width: 1, ...noPoints }),
  },
  {
    columns: (curve) => [curve.line],
    style: ({ colour, dash }) => ({
      stroke: colour,
      width: LINE_WIDTH,
      dash,
      points: { show: isSinglePoint, size: 6, width: 0, fill: colour },
    }),
  },
];
const noPoints = { points: { show: false } };

/**
 * @param {Curve[]} curves
 * @returns {Pick<import("uplot").Options, "series" | "bands">}
 */
export function layers(curves) {
  /** @type {Series[]} */
  const series = [{}];
  /** @type {import("uplot").Band[]} */
  const bands = [];
  for (const { columns, style } of LAYERS) {
    for (const curve of curves) {
      const made = columns(curve).map(() => style(curve));
      if (columns === LAYERS[0].columns && made.length > 0) {
        const fill = faint(curve.colour, BAND_OPACITY);
        bands.push({ series: [series.length, series.length + 1], fill });
      }
      series.push(...made);
    }
  }
  return { series, bands };
}

/**
 * The series indices of the bold lines: the last layer.
 *
 * @param {Curve[]} curves
 * @returns {Set<number>}
 */
export function lineIndices(curves) {
  const below = LAYERS.slice(0, -1);
  const before = below.flatMap(({ columns }) => curves.flatMap((curve) => columns(curve))).length;
  return new Set(curves.map((_, i) => 1 + before + i));
}

/**
 * A curve's first measurement has no line to be seen by.
 *
 * @param {import("uplot")} plot
 * @param {number} series
 * @param {number} from
 * @param {number} to
 * @returns {boolean}
 */
function isSinglePoint(plot, series, from, to) {
  return plot.data[series].slice(from, to + 1).filter((value) => value != null).length === 1;
}

/**
 * All steps of some grids, each once, increasing; the grids' own array where they are equal.
 *
 * @param {number[][]} grids
 * @returns {number[]}
 */
export function union(grids) {
  const first = grids[0] ?? [];
  if (grids.every((grid) => isSame(grid, first))) return first;
  return [...new Set(grids.flat())].toSorted((a, b) => a - b);
}

/**
 * @param {number[]} a
 * @param {number[]} b
 * @returns {boolean}
 */
function isSame(a, b) {
  return a === b || (a.length === b.length && a.every((x, i) => x === b[i]));
}

/**
 * Puts a curve's values on the union `xs` of steps; where it has none the line passes through.
 *
 * @param {number[]} x
 * @param {number[]} xs
 * @returns {(values: Column) => Column}
 */
export function placement(x, xs) {
  if (isSame(x, xs)) return (values) => values;
  const index = new Map(xs.map((value, i) => [value, i]));
  const places = x.map((value) => /** @type {number} */ (index.get(value)));
  return (values) => {
    /** @type {Column} */
    const column = new Array(xs.length); // holes, which uPlot spans; null it keeps as a gap
    for (const [i, place] of places.entries()) column[place] = values[i];
    return column;
  };
}

/**
 * What takes a column from an index on; of -1, nothing of it.
 *
 * @param {number} from
 * @returns {<T>(column: T[]) => T[]}
 */
export function slicer(from) {
  return (column) => (from < 0 ? [] : column.slice(from));
}
