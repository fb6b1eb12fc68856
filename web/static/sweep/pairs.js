/** What is known of pairs of learners: as a matrix, and against one of them with intervals. */
import { element } from "../parts/element.js";
import { identityOf } from "../parts/identity.js";
import { swatch } from "../parts/swatch.js";
import { withBand } from "../texts/format.js";

/**
 * @import { Identities } from "../parts/identity.js"
 * @import { Estimate } from "./interval.js"
 *
 * @typedef {Api.Statistics["probability_of_improvement"]["pairs"][number]} Pair
 * @typedef {Api.Statistics["paired_differences"]["values"][number]} Difference
 *
 * @typedef {object} Cell   what stands in a matrix
 * @property {string} text
 * @property {string} title   the same with its interval
 * @property {number} tint   from -1, all for the column, to 1, all for the row
 * @property {boolean} isSure   whether the interval leaves no doubt
 */

/**
 * The labels that pairs are of, in their order.
 *
 * @param {Pair[]} pairs
 * @returns {string[]}
 */
export function labelsOf(pairs) {
  return [...new Set(pairs.flatMap(({ x, y }) => [x, y]))];
}

/**
 * The pairs with one label, which comes second in each.
 *
 * @param {Pair[]} pairs
 * @param {string} reference
 * @returns {{ x: string, y: string, estimate: Estimate }[]}
 */
export function against(pairs, reference) {
  return pairs.flatMap(({ x, y, all_pairs: estimate }) => {
    if (y === reference) return [{ x, y, estimate }];
    return x === reference ? [{ x: y, y: x, estimate: turned(estimate) }] : [];
  });
}

/**
 * A probability the other way round.
 *
 * @param {Estimate} estimate
 * @returns {Estimate}
 */
function turned({ value, low, high }) {
  const other = (/** @type {number | null} */ edge) => (edge === null ? null : 1 - edge);
  return { value: 1 - value, low: other(high), high: other(low) };
}

/**
 * How probably each row beats each column.
 *
 * @param {Pair[]} pairs
 * @param {Identities} known
 * @returns {HTMLElement}
 */
export function improvementMatrix(pairs, known) {
  const labels = labelsOf(pairs);
  /** @type {Map<string, Map<string, Estimate>>} */
  const found = new Map(
    labels.map((label) => [label, new Map(against(pairs, label).map(({ x, estimate }) => [x, estimate]))]),
  );
  const cell = (/** @type {string} */ x, /** @type {string} */ y) => {
    const estimate = found.get(y)?.get(x);
    return estimate === undefined ? null : probabilityCell(x, y, estimate);
  };
  const columns = labels.map((label, i) => ({ name: String(i + 1), title: label }));
  return matrix(labels, columns, (x, j) => cell(x, labels[j]), known, true);
}

/**
 * @param {string} x
 * @param {string} y
 * @param {Estimate} estimate
 * @returns {Cell}
 */
function probabilityCell(x, y, { value, low, high }) {
  return {
    text: value.toFixed(2),
    title: `P(${x} > ${y}) = ${withBand(value, low, high)}`,
    tint: 2 * value - 1,
    isSure: low !== null && high !== null && (low > 0.5 || high < 0.5),
  };
}

/**
 * What each row gains over its baseline, in each task.
 *
 * @param {Difference[]} values
 * @param {Identities} known
 * @returns {HTMLElement}
 */
export function differenceMatrix(values, known) {
  const tasks = [...new Set(values.map(({ environment }) => environment))];
  const baselines = new Set(values.map(({ baseline }) => baseline));
  const keyOf = (/** @type {Difference} */ { label, baseline }) =>
    baselines.size > 1 ? `${label} − ${baseline}` : label;
  const rows = [...new Map(values.map((each) => [keyOf(each), each.label]))];
  const largest = Math.max(...values.map(({ mean }) => Math.abs(mean ?? 0))) || 1;
  const columns = tasks.map((task) => ({ name: task, title: task }));
  const named = new Map(rows);
  return matrix(
    rows.map(([key]) => key),
    columns,
    (key, j) => {
      const found = values.find((each) => keyOf(each) === key && each.environment === tasks[j]);
      return found === undefined || found.mean === null ? null : differenceCell(found, largest);
    },
    known,
    false,
    (key) => named.get(key) ?? key,
  );
}

/**
 * @param {Difference} difference
 * @param {number} largest
 * @returns {Cell}
 */
function differenceCell({ mean, low, high, wins, n, pairs }, largest) {
  const value = mean ?? 0;
  const left = n < pairs ? `, of ${pairs}` : "";
  return {
    text: `${value > 0 ? "+" : ""}${value.toFixed(3)}`.replace("-", "−"),
    title: `${withBand(value, low, high)}, ${wins} of ${n} pairs won${left}`,
    tint: value / largest,
    isSure: low !== null && high !== null && (low > 0 || high < 0),
  };
}

/**
 * @param {string[]} rows
 * @param {{ name: string, title: string }[]} columns
 * @param {(row: string, column: number) => Cell | null} cellAt
 * @param {Identities} known
 * @param {boolean} isNumbered whether rows have the numbers that columns are called by
 * @param {(row: string) => string} [labelOf] whose colour a row has
 * @returns {HTMLElement}
 */
function matrix(rows, columns, cellAt, known, isNumbered, labelOf = (row) => row) {
  const heads = columns.map(({ name, title }) => element("th", { scope: "col", title }, name));
  const body = rows.map((row, i) => {
    const name = isNumbered ? `${i + 1} ${row}` : row;
    const head = element("th", { scope: "row" }, swatch(identityOf(known, labelOf(row))), name);
    return element("tr", {}, head, ...columns.map((_, j) => matrixCell(cellAt(row, j))));
  });
  const head = element("tr", {}, element("td"), ...heads);
  return element(
    "table",
    { class: "data matrix" },
    element("thead", {}, head),
    element("tbody", {}, ...body),
  );
}

/**
 * @param {Cell | null} cell
 * @returns {HTMLElement}
 */
function matrixCell(cell) {
  if (cell === null) return element("td", { class: "muted" }, "–");
  const { text, title, tint, isSure } = cell;
  const node = element("td", { title }, element(isSure ? "strong" : "span", {}, text));
  const strength = Math.round(Math.min(1, Math.abs(tint)) * 30);
  const side = tint > 0 ? "var(--good)" : "var(--warning)";
  node.style.background = `color-mix(in srgb, ${side} ${strength}%, transparent)`;
  return node;
}
