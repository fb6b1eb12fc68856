/** Curves as uPlot's columns and series, on the union of the steps that they were measured at. */
import { faint } from "../parts/palette.js";

const BAND_OPACITY = 0.16;
const FAINT_OPACITY = 0.35;
const SEED_OPACITY = 0.3;
const LINE_WIDTH = 2;

/** uPlot's columns [x, ...series], in the order of `layers`, on the union of the curves' steps. */
export function align(curves) {
  const xs = union(curves.map((curve) => curve.x));
  const onto = curves.map((curve) => placement(curve.x, xs));
  const each = (pick) => curves.flatMap((curve, i) => pick(curve).map((column) => onto[i](column)));
  return [xs, ...LAYERS.flatMap(({ columns }) => each(columns))];
}

/** What is drawn, back to front: each layer takes some columns of every curve. */
const LAYERS = [
  {
    columns: (curve) => (curve.low ? [curve.high, curve.low] : []),
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

export function layers(curves) {
  const series = [{}];
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

/** The series indices of the bold lines: the last layer. */
export function lineIndices(curves) {
  const before = LAYERS.slice(0, -1).flatMap(({ columns }) => curves.flatMap(columns)).length;
  return new Set(curves.map((_, i) => 1 + before + i));
}

/** A curve's first measurement has no line to be seen by. */
function isSinglePoint(plot, series, from, to) {
  return plot.data[series].slice(from, to + 1).filter((value) => value != null).length === 1;
}

/** All steps of some grids, each once, increasing; the grids' own array where they are equal. */
export function union(grids) {
  const first = grids[0] ?? [];
  if (grids.every((grid) => isSame(grid, first))) return first;
  return [...new Set(grids.flat())].sort((a, b) => a - b);
}

function isSame(a, b) {
  return a === b || (a.length === b.length && a.every((x, i) => x === b[i]));
}

/** Puts a curve's values on the union `xs` of steps; where it has none the line passes through. */
export function placement(x, xs) {
  if (isSame(x, xs)) return (values) => values;
  const index = new Map(xs.map((value, i) => [value, i]));
  const places = x.map((value) => index.get(value));
  return (values) => {
    const column = new Array(xs.length); // undefined, which uPlot spans; null it keeps as a gap
    places.forEach((place, i) => (column[place] = values[i]));
    return column;
  };
}
