/** From the service's curves to what a chart draws, under the view that a person chose. */
import { smooth } from "./smoothing.js";

/** Metrics that are returns: only these have a normalised scale and a random policy to lie above. */
export const RETURNS = ["return_mean", "return_history"];

/**
 * @param panel one environment of the service's answer
 * @param known the sweep's identities (identity.js)
 * @param view what to show (view.js)
 * @param axes { xLabel, yLabel, xMax } as text and number
 * @returns the Data of chart.js
 */
export function chartData(panel, known, view, axes) {
  const curves = panel.curves
    .filter((curve) => !view.get("hide").includes(curve.label))
    .map((curve) => drawnCurve(curve, known.get(curve.label), view));
  const references = referenceLines(panel, view);
  return {
    curves,
    references,
    x: { label: axes.xLabel, log: view.get("logx"), max: axes.xMax },
    y: {
      label: axes.yLabel,
      anchors: references.map((line) => line.value),
      ...yScale(curves, references, view.get("logy")),
    },
  };
}

/** A logarithmic axis takes positive values only; else both sides of zero get one of their own. */
export function yScale(curves, references, isLog) {
  if (!isLog) return { scale: "linear", linearWithin: 1 };
  const values = [...curves.flatMap(drawnValues), ...references.map((line) => line.value)];
  if (values.every((value) => value > 0)) return { scale: "log", linearWithin: 1 };
  const largest = values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  return { scale: "symlog", linearWithin: 10 ** Math.floor(Math.log10(largest || 1) - 1) };
}

function drawnValues({ line, low, high, raw, seeds }) {
  const columns = [line, low ?? [], high ?? [], raw ?? [], ...(seeds ?? [])];
  return columns.flat().filter((value) => value !== null);
}

function drawnCurve(curve, { label, colour, dash }, view) {
  const shown = view.get("logx") ? positiveSteps(curve) : curve;
  const weight = view.get("smoothing");
  const drawn = { label, colour, dash, x: shown.x, mean: shown.mean, n: shown.n };
  drawn.line = weight > 0 ? smooth(shown.mean, weight) : shown.mean;
  if (weight > 0) drawn.raw = shown.mean;
  if (view.get("band") !== "none") Object.assign(drawn, { low: shown.low, high: shown.high });
  if (view.get("seeds")) drawn.seeds = (shown.seeds ?? []).map((seed) => seed.values);
  return drawn;
}

/** A logarithmic axis has no place for zero, where ddpg stands for ever along Jacobians. */
function positiveSteps(curve) {
  const from = curve.x.findIndex((x) => x > 0);
  const rest = (values) => (from < 0 ? [] : values.slice(from));
  return {
    x: rest(curve.x),
    mean: rest(curve.mean),
    low: rest(curve.low),
    high: rest(curve.high),
    n: rest(curve.n),
    seeds: curve.seeds?.map((seed) => ({ ...seed, values: rest(seed.values) })),
  };
}

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
