/** What a panel shows, in words: band, n, normalisation, and every choice that changes the look. */
import { counted, number } from "../texts/format.js";
import { RETURNS } from "./drawing.js";

/**
 * @import { View } from "../parts/view.js"
 * @import { Data } from "../charts/chart.js"
 * @import { Fields } from "./drawing.js"
 */

const BANDS = {
  std: "mean ± one standard deviation (ddof 1)",
  ci95: "mean and its 95 % confidence interval (Student’s t)",
  iqr: "mean and interquartile range (25 % to 75 %)",
  none: "mean",
};

/**
 * The caption under one panel.
 *
 * @param {Api.Panel} panel
 * @param {View<Fields>} view
 * @param {Data} data
 * @param {Set<string>} hidden labels
 * @returns {string}
 */
export function panelCaption(panel, view, { x, y }, hidden) {
  const statistic = BANDS[view.get("band")];
  const sentences = [
    `${statistic[0].toUpperCase()}${statistic.slice(1)}, n = ${seedsText(panel.curves)}.`,
    scaleText(panel, view),
    ...displayText(panel, view, hidden),
    axisText(view.get("logx"), y),
    limitsText(x, y, view.get("robust")),
  ];
  return sentences.filter((sentence) => sentence !== "").join(" ");
}

/**
 * How many seeds the curves rest on: "16 seeds", or "2 to 16 seeds" where they differ.
 *
 * @param {Api.Curve[]} curves
 * @returns {string}
 */
function seedsText(curves) {
  const counts = curves.flatMap((curve) => curve.n);
  const most = counts.reduce((a, b) => Math.max(a, b), 0);
  const least = counts.reduce((a, b) => Math.min(a, b), most);
  return least === most ? counted(most, "seed") : `${least} to ${counted(most, "seed")}`;
}

/**
 * @param {Api.Panel} panel
 * @param {View<Fields>} view
 * @returns {string}
 */
function scaleText({ random_return: random }, view) {
  if (!RETURNS.includes(view.get("metric"))) return "";
  if (view.get("scale") === "raw") return "Raw, undiscounted returns.";
  if (random === null) {
    return "The random policy has not been measured yet; until then there is no normalised return.";
  }
  return (
    `0 is the random policy (return ${number(random.mean)}, 95 % interval ` +
    `${number(random.low)} to ${number(random.high)}, ${counted(random.episodes, "episode")}), ` +
    "1 the largest reward at every step."
  );
}

/**
 * @param {Api.Panel} panel
 * @param {View<Fields>} view
 * @param {Set<string>} labels that are hidden
 * @returns {string[]}
 */
function displayText(panel, view, labels) {
  const sentences = [];
  if (view.get("smoothing") > 0) {
    sentences.push(
      `Bold lines are smoothed for display (debiased exponential average, weight ` +
        `${view.get("smoothing")}); the mean itself is the faint line, band and table are exact.`,
    );
  }
  if (view.get("seeds")) sentences.push("Thin lines are single seeds.");
  const hidden = panel.curves.filter((curve) => labels.has(curve.label)).length;
  if (hidden > 0) sentences.push(`${counted(hidden, "curve")} hidden.`);
  return sentences;
}

/**
 * @param {Data["x"]} x
 * @param {Data["y"]} y
 * @param {boolean} isRobust
 * @returns {string}
 */
function limitsText(x, y, isRobust) {
  const isCut = [...x.limits, ...y.limits].some((limit) => limit !== null);
  if (!isCut) return "";
  const left = isRobust ? " (set without outliers, 2 % at either end)" : "";
  return `Axes have limits${left}; what lies beyond them is not shown.`;
}

/**
 * @param {boolean} logX
 * @param {Data["y"]} y
 * @returns {string}
 */
function axisText(logX, { scale, linearWithin }) {
  const parts = [];
  if (logX) parts.push("horizontal axis logarithmic");
  if (scale === "log") parts.push("vertical axis logarithmic");
  if (scale === "symlog") {
    parts.push(
      `vertical axis logarithmic on both sides of zero (asinh), linear within ±${number(linearWithin)}`,
    );
  }
  if (parts.length === 0) return "";
  const text = parts.join(", ");
  return `${text[0].toUpperCase()}${text.slice(1)}.`;
}
