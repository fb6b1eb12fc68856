/** What the service is asked to draw, so that a file shows what the screen shows. */
import { question } from "../curves/question.js";
import { hiddenLabels } from "../curves/selection.js";
import { limit, list, oneOf, on, whole } from "../parts/view.js";

/**
 * @import { Fields as CurveFields } from "../curves/drawing.js"
 * @import { View } from "../parts/view.js"
 *
 * @typedef {CurveFields & typeof FIGURE_FIELDS} Fields
 * @typedef {Api.Query<`/sweeps/${string}/plot.csv`>} FigureQuery
 */

/** How a figure looks on paper. */
export const FIGURE_FIELDS = {
  columns: oneOf("", "1", "2"),
  width: limit, // inches
  height: limit,
  font_size: limit, // points
  font_family: oneOf("sans-serif", "serif", "monospace"),
  per_row: whole, // panels; 0 as it needs
  title: on,
  caption: on,
  legend: on,
  task: list, // those shown, in this order; none: all
  entry: list, // labels in their order; those that are not named come after them
  name: list, // "label=what it is called"
  colour: list, // "label=#0072b2"
};

/**
 * @param {View<Fields>} view
 * @param {Api.Panel[]} panels as on the screen
 * @param {number | null} xMax where the x axis ends there, if that is known
 * @returns {FigureQuery}
 */
export function figureQuery(view, panels, xMax) {
  const { metric, max_points, ...asked } = question(view);
  const width = view.get("width");
  return {
    ...asked,
    max_points,
    metric: [String(metric)],
    band: view.get("band"),
    smoothing: view.get("smoothing"),
    logx: view.get("logx"),
    logy: view.get("logy"),
    xmin: view.get("from") ?? (view.get("logx") ? null : 0),
    xmax: view.get("to") ?? xMax,
    ymin: view.get("ymin"),
    ymax: view.get("ymax"),
    robust: view.get("robust"),
    align: view.get("align"),
    environment: view.get("task"),
    entry: shownEntries(view, panels),
    name: view.get("name"),
    colour: view.get("colour"),
    columns: /** @type {any} */ (width === null ? view.get("columns") : null), // "1" is 1 in an address
    width,
    height: view.get("height"),
    font_size: view.get("font_size") ?? undefined,
    font_family: view.get("font_family"),
    per_row: view.get("per_row") || null,
    title: view.get("title"),
    caption: view.get("caption"),
    legend: view.get("legend"),
  };
}

/**
 * The labels of the curves that are shown, in the order of the figure.
 *
 * @param {View<Fields>} view
 * @param {Api.Panel[]} panels
 * @returns {string[]}
 */
export function shownEntries(view, panels) {
  const hidden = hiddenLabels(panels, view);
  const labels = [...new Set(panels.flatMap((panel) => panel.curves.map(({ label }) => label)))];
  const shown = labels.filter((label) => !hidden.has(label));
  const first = view.get("entry").filter((label) => shown.includes(label));
  return [...first, ...shown.filter((label) => !first.includes(label))];
}
