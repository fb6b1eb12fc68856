/** The twin of a chart: every value that it draws, as a table and as CSV. */
import { element } from "../parts/element.js";
import { count, number } from "../texts/format.js";

/**
 * What is in each row of the service's curves.
 *
 * @typedef {Pick<Api.Curve, "label" | "x" | "mean" | "low" | "high" | "n">} TableCurve
 */

/**
 * Fill a table with a row per step, and mean, band and n of every curve.
 *
 * @param {HTMLTableElement} table
 * @param {TableCurve[]} curves
 * @param {string} abscissa
 * @param {string} metric
 */
export function fillCurveTable(table, curves, abscissa, metric) {
  const steps = [...new Set(curves.flatMap((curve) => curve.x))].toSorted((a, b) => a - b);
  const rows = curves.map((curve) => new Map(curve.x.map((x, i) => [x, i])));
  table.replaceChildren(
    element("caption", { class: "visually-hidden" }, `${metric} by ${abscissa}`),
    head(curves, abscissa),
    element("tbody", {}, ...steps.map((x) => row(x, curves, rows))),
  );
}

/**
 * @param {TableCurve[]} curves
 * @param {string} abscissa
 * @returns {HTMLElement}
 */
function head(curves, abscissa) {
  const first = element("th", { scope: "col", rowspan: "2" }, abscissa);
  const names = curves.map((curve) =>
    element("th", { scope: "colgroup", colspan: "4", class: "group" }, curve.label),
  );
  const columns = curves.flatMap(() =>
    ["mean", "low", "high", "n"].map((name) => element("th", { scope: "col" }, name)),
  );
  return element("thead", {}, element("tr", {}, first, ...names), element("tr", {}, ...columns));
}

/**
 * @param {number} x
 * @param {TableCurve[]} curves
 * @param {Map<number, number>[]} rows
 * @returns {HTMLElement}
 */
function row(x, curves, rows) {
  const cells = curves.flatMap((curve, c) => {
    const i = rows[c].get(x);
    if (i === undefined) return ["", "", "", ""];
    return [number(curve.mean[i]), number(curve.low[i]), number(curve.high[i]), count(curve.n[i])];
  });
  const step = Number.isInteger(x) ? count(x) : number(x);
  return element(
    "tr",
    {},
    element("th", { scope: "row" }, step),
    ...cells.map((text) => element("td", {}, text)),
  );
}

const COLUMNS = "environment,curve,algorithm,w1,w2,metric,normalized,band,x_axis,x,mean,low,high,n";

/**
 * The service's curves as CSV (RFC 4180), a line per point, values in full precision.
 *
 * @param {Pick<Api.Curves, "metric" | "normalized" | "band" | "x" | "panels">} comparison
 * @returns {string}
 */
export function toCsv(comparison) {
  const { metric, normalized, band, x: abscissa, panels } = comparison;
  const lines = panels.flatMap(({ environment, curves }) =>
    curves.flatMap(({ label, algorithm, weights, x, mean, low, high, n }) =>
      x.map((step, i) =>
        [environment, label, algorithm, weights.w1, weights.w2, metric, normalized, band, abscissa]
          .map(quoted)
          .concat([step, mean[i], low[i], high[i], n[i]].map(quoted))
          .join(),
      ),
    ),
  );
  return [COLUMNS, ...lines, ""].join("\r\n");
}

/**
 * @param {unknown} value
 * @returns {string}
 */
function quoted(value) {
  const text = String(value ?? "");
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/**
 * Let the browser save a text as a file.
 *
 * @param {string} text
 * @param {string} name
 */
export function saveText(text, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}
