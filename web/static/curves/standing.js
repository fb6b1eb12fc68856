/** What each curve is worth, as one number: where the cursor is, or at its end. */
import { lastUpTo } from "../charts/readout.js";
import { isNormalized } from "./question.js";
import { latest } from "./selection.js";

/**
 * @import { View } from "../parts/view.js"
 * @import { Fields } from "./drawing.js"
 * @import { Reading } from "./panel.js"
 */

/**
 * The value of each curve at the cursor of one panel; without a cursor its latest, over several
 * tasks the mean of normalised ones.
 *
 * @param {Api.Panel[]} panels
 * @param {Reading} reading
 * @param {View<Fields>} view
 * @returns {Map<string, number>} by label, of those that have one
 */
export function standing(panels, reading, view) {
  if (reading !== null) {
    const read = panels.find(({ environment }) => environment === reading.environment);
    return means(read ? [read] : [], (curve) => valueAt(curve, reading.x));
  }
  return panels.length > 1 && !isNormalized(view) ? new Map() : means(panels, ({ mean }) => latest(mean));
}

/**
 * @param {Api.Panel[]} panels
 * @param {(curve: Api.Curve) => number} valueOf not finite where there is none
 * @returns {Map<string, number>}
 */
function means(panels, valueOf) {
  /** @type {Map<string, number[]>} */
  const found = new Map();
  for (const curve of panels.flatMap((panel) => panel.curves)) {
    const value = valueOf(curve);
    if (Number.isFinite(value)) found.set(curve.label, [...(found.get(curve.label) ?? []), value]);
  }
  const mean = (/** @type {number[]} */ values) => values.reduce((a, b) => a + b, 0) / values.length;
  return new Map([...found].map(([label, values]) => [label, mean(values)]));
}

/**
 * @param {Api.Curve} curve
 * @param {number} x
 * @returns {number} NaN beyond its end, and before its start
 */
function valueAt({ x: steps, mean }, x) {
  const i = x > (steps.at(-1) ?? -Infinity) ? -1 : lastUpTo(steps, x);
  return mean[i] ?? NaN;
}
