/** Where a chart's axes end, as far as a person says so. */

/**
 * @import { CURVE_FIELDS, View } from "../parts/view.js"
 *
 * @typedef {Pick<View<typeof CURVE_FIELDS>, "get">} Limited
 * @typedef {[low: number | null, high: number | null]} Limits   null where the data decide
 */

const OUTLIERS = 0.02; // of the values at either end

/**
 * @param {Limited} view
 * @returns {{ limits: Limits }}
 */
export function xLimits(view) {
  return { limits: [view.get("from"), view.get("to")] };
}

/**
 * A limit that was said, else that of all panels, else that of all values but outliers.
 *
 * @param {Limited} view
 * @param {number[]} values of the lines
 * @param {[low: number, high: number] | null} [shared]
 * @returns {{ limits: Limits }}
 */
export function yLimits(view, values, shared = null) {
  const isRobust = view.get("robust") && values.length > 0;
  const [low, high] = shared ?? (isRobust ? range(values, true) : [null, null]);
  return { limits: [view.get("ymin") ?? low, view.get("ymax") ?? high] };
}

/**
 * The least and the greatest of some values, of all or of those that are no outliers.
 *
 * @param {number[]} values
 * @param {boolean} isRobust
 * @returns {[low: number, high: number]}
 */
export function range(values, isRobust) {
  const sorted = values.toSorted((a, b) => a - b);
  const left = isRobust ? Math.floor(OUTLIERS * (sorted.length - 1)) : 0;
  return [sorted[left], sorted[sorted.length - 1 - left]];
}
