/** From the service's curves to what a chart draws, under the view that a person chose. */
import { identityOf } from "../parts/identity.js";
import { smooth, yScale } from "./y_scale.js";

/**
 * @import { Identities, Identity } from "../parts/identity.js"
 * @import { CURVE_FIELDS, Field, View } from "../parts/view.js"
 * @import { Data, Reference } from "./chart.js"
 * @import { Curve } from "./layers.js"
 * @import { YScale } from "./y_scale.js"
 *
 * @typedef {{ xLabel: string, yLabel: string, xMax: number | null }} Axes
 *
 * @typedef {typeof CURVE_FIELDS & CurvesFields} Fields   of a view that draws a sweep's curves
 *
 * @typedef {object} CurvesFields
 * @property {Field<string>} metric
 * @property {Field<"normalized" | "raw">} scale
 * @property {Field<"std" | "ci95" | "iqr" | "none">} band
 * @property {Field<boolean>} seeds
 * @property {Field<string[]>} hide
 */

/** Metrics that are returns: only these have a normalised scale and a random policy to lie above. */
export const RETURNS = ["return_mean", "return_history"];

/**
 * @param {Api.Panel} panel
 * @param {Identities} known
 * @param {View<Fields>} view
 * @param {Axes} axes
 * @returns {Data}
 */
export function chartData(panel, known, view, axes) {
  const shown = panel.curves
    .filter((curve) => !view.get("hide").includes(curve.label))
    .map((curve) => (view.get("logx") ? positiveSteps(curve) : curve));
  const references = referenceLines(panel, view);
  const marks = references.map((line) => line.value);
  const values = shown.flatMap((curve) => lineValues(curve, view.get("seeds")));
  const scale = yScale([...values, ...marks], view.get("logy"));
  return {
    curves: shown.map((curve) => drawnCurve(curve, identityOf(known, curve.label), view, scale)),
    references,
    x: { label: axes.xLabel, log: view.get("logx"), max: axes.xMax },
    y: { label: axes.yLabel, anchors: marks, ...scale },
  };
}

/**
 * @param {Api.Curve} curve
 * @param {boolean} withSeeds
 * @returns {number[]}
 */
function lineValues({ mean, seeds }, withSeeds) {
  const columns = [mean, ...(withSeeds ? (seeds ?? []).map((seed) => seed.values) : [])];
  return columns.flat().filter((value) => value !== null);
}

/**
 * @param {Api.Curve} curve
 * @param {Identity} identity
 * @param {View<Fields>} view
 * @param {YScale} scale
 * @returns {Curve}
 */
function drawnCurve({ x, mean, low, high, n, seeds }, { label, colour, dash }, view, scale) {
  const weight = view.get("smoothing");
  /** @type {Curve} */
  const drawn = { label, colour, dash, line: mean, x, mean, n };
  if (weight > 0) Object.assign(drawn, { line: smooth(mean, weight, scale), raw: mean });
  if (view.get("band") !== "none") Object.assign(drawn, { low, high });
  if (view.get("seeds")) drawn.seeds = (seeds ?? []).map((seed) => seed.values);
  return drawn;
}

/**
 * A logarithmic axis has no place for zero, where ddpg stands for ever along Jacobians.
 *
 * @param {Api.Curve} curve
 * @returns {Api.Curve}
 */
function positiveSteps(curve) {
  const rest = slicer(curve.x.findIndex((x) => x > 0));
  return {
    ...curve,
    x: rest(curve.x),
    mean: rest(curve.mean),
    low: rest(curve.low),
    high: rest(curve.high),
    n: rest(curve.n),
    seeds: curve.seeds?.map((seed) => ({ ...seed, values: rest(seed.values) })),
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

/**
 * @param {Api.Panel} panel
 * @param {View<Fields>} view
 * @returns {Reference[]}
 */
function referenceLines(panel, view) {
  if (!RETURNS.includes(view.get("metric"))) return [];
  if (view.get("scale") === "normalized") {
    return [
      { value: 0, label: "random" },
      { value: 1, label: "maximum" },
    ];
  }
  const random = panel.random_return;
  return random === null ? [] : [{ value: random.mean, label: "random" }];
}
