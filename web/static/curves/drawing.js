/** From the service's curves to what a chart draws, under the view that a person chose. */
import { identityOf } from "../parts/identity.js";
import { slicer } from "../charts/layers.js";
import { range, xLimits, yLimits } from "../charts/limits.js";
import { smooth, yScale } from "../charts/y_scale.js";

/**
 * @import { Identities, Identity } from "../parts/identity.js"
 * @import { COMPARISON_FIELDS, View } from "../parts/view.js"
 * @import { Data, Reference } from "../charts/chart.js"
 * @import { Curve } from "../charts/layers.js"
 * @import { YScale } from "../charts/y_scale.js"
 *
 * @typedef {object} Axes
 * @property {string} xLabel
 * @property {string} yLabel
 * @property {number | null} xMax
 * @property {[low: number, high: number] | null} yShared   of the y axes of all panels
 *
 * @typedef {typeof COMPARISON_FIELDS} Fields
 */

/** Metrics that are returns: only these have a normalised scale and a random policy to lie above. */
export const RETURNS = ["return_mean", "return_history"];

/**
 * @param {Api.Panel} panel
 * @param {Identities} known
 * @param {View<Fields>} view
 * @param {Axes} axes
 * @param {Set<string>} hidden labels
 * @returns {Data}
 */
export function chartData(panel, known, view, axes, hidden) {
  const shown = shownCurves(panel, view, hidden);
  const references = referenceLines(panel, view);
  const marks = references.map((line) => line.value);
  const values = shown.flatMap((curve) => lineValues(curve, view.get("seeds")));
  const scale = yScale([...values, ...marks], view.get("logy"));
  return {
    curves: shown.map((curve) => drawnCurve(curve, identityOf(known, curve.label), view, scale)),
    references,
    x: { label: axes.xLabel, log: view.get("logx"), max: axes.xMax, ...xLimits(view) },
    y: {
      label: axes.yLabel,
      anchors: marks,
      ...scale,
      ...yLimits(view, values, axes.yShared),
    },
  };
}

/**
 * What all y axes have in common where they are aligned: the range of every line that is shown.
 *
 * @param {Api.Panel[]} panels
 * @param {View<Fields>} view
 * @param {Set<string>} hidden
 * @returns {Axes["yShared"]}
 */
export function sharedRange(panels, view, hidden) {
  if (!view.get("align")) return null;
  const curves = panels.flatMap((panel) => shownCurves(panel, view, hidden));
  const values = curves.flatMap((curve) => lineValues(curve, view.get("seeds")));
  return values.length === 0 ? null : range(values, view.get("robust"));
}

/**
 * @param {Api.Panel} panel
 * @param {View<Fields>} view
 * @param {Set<string>} hidden
 * @returns {Api.Curve[]}
 */
function shownCurves(panel, view, hidden) {
  return panel.curves
    .filter((curve) => !hidden.has(curve.label))
    .map((curve) => (view.get("logx") ? positiveSteps(curve) : curve));
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
