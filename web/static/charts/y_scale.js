/** The scale of a chart's y axis, and what follows from it for what is drawn. */

/**
 * @import { Scale } from "./chart.js"
 * @import { Curve } from "./layers.js"
 *
 * @typedef {object} YScale
 * @property {Scale} scale
 * @property {number} linearWithin   symlog is linear in [-linearWithin, linearWithin]
 * @property {number} floor   no band goes below it: half of the least value on a logarithmic axis
 */

/** @type {YScale} */
const LINEAR = { scale: "linear", linearWithin: 1, floor: -Infinity };

/**
 * A logarithmic axis takes positive values only; else both sides of zero get one of their own.
 *
 * @param {number[]} values of the lines; a band around them may reach below zero, and is cut off
 * @param {boolean} isLog
 * @returns {YScale}
 */
export function yScale(values, isLog) {
  if (!isLog) return LINEAR;
  const least = values.reduce((a, b) => Math.min(a, b), Infinity);
  if (least > 0) return { scale: "log", linearWithin: 1, floor: least / 2 };
  const largest = values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  const linearWithin = 10 ** Math.floor(Math.log10(largest || 1) - 1);
  return { scale: "symlog", linearWithin, floor: -Infinity };
}

/**
 * A curve with its band cut off where the axis ends.
 *
 * @param {Curve} curve
 * @param {YScale} scale
 * @returns {Curve}
 */
export function withinAxis(curve, { floor }) {
  if (floor === -Infinity || !curve.low || !curve.high) return curve;
  const cut = (/** @type {number | null} */ value) => (value === null ? null : Math.max(value, floor));
  return { ...curve, low: curve.low.map(cut), high: curve.high.map(cut) };
}

/**
 * The debiased exponential average: for a weight b in [0, 1) and finite values v,
 *
 *   m_k = b m_{k-1} + (1 - b) f(v_k),   s_k = f^-1(m_k / (1 - b^k)),   k counting finite values only,
 *
 * where f takes values to the axis: the average of what is seen. A constant stays itself from the
 * first value on, and the result depends on the values before it alone. Missing values stay missing
 * and leave the average as it was.
 *
 * @param {(number | null)[]} values
 * @param {number} weight b; 0 gives the values back
 * @param {YScale} [scale]
 * @returns {(number | null)[]}
 */
export function smooth(values, weight, scale = LINEAR) {
  const [onto, back] = transformation(scale);
  let average = 0;
  let total = 0; // the weights so far add up to 1 - b^k
  return values.map((value) => {
    if (value === null || value === undefined) return value;
    average = weight * average + (1 - weight) * onto(value);
    total = weight * total + (1 - weight);
    return back(average / total);
  });
}

/**
 * @param {YScale} scale
 * @returns {[onto: (value: number) => number, back: (place: number) => number]}
 */
function transformation({ scale, linearWithin }) {
  if (scale === "log") return [Math.log, Math.exp];
  if (scale === "linear") return [(value) => value, (place) => place];
  return [(value) => Math.asinh(value / linearWithin), (place) => linearWithin * Math.sinh(place)];
}
