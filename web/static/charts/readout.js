/** The values under a chart's cursor: a box beside it for eyes, a sentence for screen readers. */
import { element, setText } from "../parts/element.js";
import { swatch } from "../parts/swatch.js";
import { withBand } from "../texts/format.js";

/**
 * @import { Curve } from "./layers.js"
 *
 * What a curve is at a step: nothing, where it has no value there.
 *
 * @typedef {object} Values
 * @property {Curve} curve
 * @property {number | null} mean
 * @property {number | null} low
 * @property {number | null} high
 * @property {number | null} n
 */

const GAP = 14;
const MOST_ROWS = 8; // more would cover the chart; a legend has them all

export class Readout {
  node = element("div", { class: "readout", "aria-hidden": "true", hidden: true });
  #step = element("p", { class: "readout-step" });
  #rows = element("tbody");
  #rest = element("p", { class: "readout-step" });
  /** @type {{ value: HTMLElement, n: HTMLElement }[]} */
  #cells = [];
  #labels = "";

  constructor() {
    this.node.append(this.#step, element("table", {}, this.#rows), this.#rest);
  }

  /**
   * Show one step.
   *
   * @param {string} step "timesteps 12,000"
   * @param {Values[]} values from `valuesAt`
   * @param {number} left where the cursor is, in CSS pixels within the plot of `width`
   * @param {number} width
   */
  show(step, values, left, width) {
    const shown = highest(values);
    this.#prepare(shown.map(({ curve }) => curve));
    setText(this.#step, step);
    const others = values.length - shown.length;
    setText(this.#rest, others > 0 ? `and ${others} lower` : "");
    shown.forEach(({ mean, low, high, n }, i) => {
      const cells = this.#cells[i];
      setText(cells.value, withBand(mean, low, high));
      setText(cells.n, n === null ? "" : `n ${n}`);
    });
    this.node.hidden = false;
    const box = this.node.offsetWidth;
    const fits = left + GAP + box <= width;
    this.node.style.left = `${Math.max(0, fits ? left + GAP : left - GAP - box)}px`;
  }

  hide() {
    this.node.hidden = true;
  }

  /** @param {Curve[]} curves */
  #prepare(curves) {
    const labels = JSON.stringify(curves.map(({ label, colour, dash }) => [label, colour, dash]));
    if (labels === this.#labels) return;
    this.#labels = labels;
    this.#cells = curves.map(() => ({
      value: element("td", { class: "number" }),
      n: element("td", { class: "number" }),
    }));
    this.#rows.replaceChildren(
      ...curves.map((curve, i) => {
        const { value, n } = this.#cells[i];
        const name = element("th", { scope: "row" }, swatch(curve), curve.label);
        return element("tr", {}, name, value, n);
      }),
    );
  }
}

/**
 * The values that the box has room for: all, or the highest of them, in the order of the curves.
 *
 * @param {Values[]} values
 * @returns {Values[]}
 */
function highest(values) {
  if (values.length <= MOST_ROWS) return values;
  const rank = (/** @type {Values} */ { mean }) => mean ?? -Infinity;
  const kept = new Set(values.toSorted((a, b) => rank(b) - rank(a)).slice(0, MOST_ROWS));
  return values.filter((each) => kept.has(each));
}

/**
 * Every curve's values at a step: those of its own last measurement up to there, none beyond its
 * end. Curves of one grid are thus read at exactly the same step.
 *
 * @param {Curve[]} curves
 * @param {number} x
 * @returns {Values[]}
 */
export function valuesAt(curves, x) {
  return curves.map((curve) => {
    const i = x > (curve.x.at(-1) ?? -Infinity) ? -1 : lastUpTo(curve.x, x);
    if (i < 0) return { curve, mean: null, low: null, high: null, n: null };
    const low = curve.low?.[i] ?? null;
    return { curve, mean: curve.mean[i], low, high: curve.high?.[i] ?? null, n: curve.n[i] };
  });
}

/**
 * The same as a sentence.
 *
 * @param {string} step
 * @param {Values[]} values
 * @returns {string}
 */
export function sentence(step, values) {
  const parts = values
    .filter(({ mean }) => mean !== null)
    .map(({ curve, mean, low, high, n }) => `${curve.label} ${withBand(mean, low, high)}, n ${n}`);
  return `${step}: ${parts.join("; ") || "no values"}`;
}

/**
 * The index of the last step that is not after x; -1 when all are.
 *
 * @param {number[]} steps
 * @param {number} x
 * @returns {number}
 */
export function lastUpTo(steps, x) {
  let low = -1;
  let high = steps.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (steps[middle] <= x) low = middle;
    else high = middle;
  }
  return low;
}
