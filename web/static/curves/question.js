/** What the service is asked for curves under a view: only what changes its answer. */
import { RETURNS } from "./drawing.js";

/**
 * @import { View } from "../parts/view.js"
 * @import { Fields } from "./drawing.js"
 *
 * @typedef {Api.Query<`/sweeps/${string}/curves`>} Question
 */

const MAX_POINTS = 300;

/**
 * @param {View<Fields>} view
 * @returns {Question}
 */
export function question(view) {
  const band = view.get("band");
  return {
    metric: view.get("metric"),
    normalized: isNormalized(view),
    band: band === "none" ? "std" : band,
    x: view.get("x"),
    max_points: MAX_POINTS,
    seeds: view.get("seeds"),
  };
}

/**
 * Whether what is asked for has a normalised scale, and that is the one that is shown.
 *
 * @param {View<Fields>} view
 * @returns {boolean}
 */
export function isNormalized(view) {
  return RETURNS.includes(view.get("metric")) && view.get("scale") === "normalized";
}

/**
 * What the view shows of curves that were answered for several sweeps, as an answer says it.
 *
 * @param {View<Fields>} view
 * @returns {Pick<Api.Curves, "metric" | "normalized" | "band" | "x">}
 */
export function comparisonOf(view) {
  return {
    metric: view.get("metric"),
    normalized: isNormalized(view),
    band: question(view).band ?? "std",
    x: view.get("x"),
  };
}
