/** The charts of one run, which share their cursor. */
import { ChartFigure, remembersTable } from "../charts/figure.js";
import { slicer } from "../charts/layers.js";
import { xLimits, yLimits } from "../charts/limits.js";
import { smooth, yScale } from "../charts/y_scale.js";
import { element, keyed } from "../parts/element.js";
import { algorithmColour, dashPattern, shades } from "../parts/palette.js";
import { xLabel } from "../parts/view.js";
import { count, number } from "../texts/format.js";
import { abscissa, chartsOf } from "./diagnostics.js";

/**
 * @import { CURVE_FIELDS, View } from "../parts/view.js"
 * @import { Data } from "../charts/chart.js"
 * @import { Curve } from "../charts/layers.js"
 * @import { ChartOf, Columns } from "./diagnostics.js"
 *
 * @typedef {typeof CURVE_FIELDS} Fields
 * @typedef {Pick<import("./context.js").Context, "random" | "best">} Marks
 * @typedef {{ chart: ChartOf, run: Api.Run, columns: Columns, view: View<Fields>, marks: Marks }} Shown
 */

export class RunCharts {
  #view;
  #show;

  /**
   * @param {HTMLElement} container
   * @param {View<Fields>} view
   */
  constructor(container, view) {
    this.#view = view;
    this.#show = keyed(
      container,
      (/** @type {Shown} */ { chart }) => chart.title,
      ({ chart }) => new RunChart(chart.title, view),
    );
  }

  /**
   * @param {Api.Run} run
   * @param {Columns} columns
   * @param {Marks} marks of the task's scale
   */
  update(run, columns, marks) {
    const view = this.#view;
    this.#show(chartsOf(columns).map((chart) => ({ chart, run, columns, view, marks })));
  }
}

const DECADES = 100; // the largest over the least value from which on an axis is logarithmic

class RunChart {
  #title;
  #figure;

  /**
   * @param {string} title
   * @param {View<Fields>} view
   */
  constructor(title, view) {
    this.#title = title;
    const texts = { title, label: title };
    this.#figure = new ChartFigure(texts, "run", {
      onToggle: remembersTable(view, title),
      onZoom: (from, to) => view.set({ from, to }),
    });
  }

  get node() {
    return this.#figure.node;
  }

  /** @param {Shown} shown */
  update({ chart, run, columns, view, marks }) {
    const data = runData(chart, run, columns, view, marks);
    const smoothed =
      view.get("smoothing") > 0 ? " Bold lines are smoothed for display, the faint ones are exact." : "";
    const texts = { caption: `${legendText(chart)}${chart.caption}${smoothed}`, abscissa: view.get("x") };
    this.#figure.update(data, texts, {
      isOpen: view.get("table").includes(this.#title),
      fill: (table) => fillTable(table, chart.names, columns, view.get("x")),
    });
  }
}

/**
 * Which line is which, where there are several.
 *
 * @param {ChartOf} chart
 * @returns {string}
 */
function legendText({ names }) {
  const styles = ["solid", "dashed", "dotted", "dash-dotted"];
  if (names.length < 2) return "";
  return `${names.map((name, i) => `${name} ${styles[i % styles.length]}`).join(", ")}. `;
}

/**
 * @param {ChartOf} chart
 * @param {Api.Run} run
 * @param {Columns} columns
 * @param {View<Fields>} view
 * @param {Marks} scale
 * @returns {Data}
 */
function runData({ title, names }, run, columns, view, scale) {
  const x = abscissa(columns, view.get("x"));
  const from = view.get("logx") ? x.findIndex((value) => value > 0) : 0;
  const rest = slicer(from);
  const references = referencesOf(title, scale);
  const marks = references.map(({ value }) => value);
  const values = names.flatMap((name) => rest(columns[name]).filter((value) => value !== null));
  const onAxis = yScale([...values, ...marks], view.get("logy") || isDueInDecades(title, values));
  const tints = shades(algorithmColour(run.algorithm), names.length);
  const curves = names.map((name, i) => {
    const mean = rest(columns[name]);
    const weight = view.get("smoothing");
    /** @type {Curve} */
    const drawn = {
      label: name,
      colour: tints[i],
      dash: dashPattern(i),
      x: rest(x),
      mean,
      line: weight > 0 ? smooth(mean, weight, onAxis) : mean,
      n: mean.map(() => 1),
    };
    return weight > 0 ? { ...drawn, raw: mean } : drawn;
  });
  const max = view.get("x") === "timesteps" ? run.timesteps : null;
  return {
    curves,
    references,
    x: { label: xLabel(view.get("x")), log: view.get("logx"), max, ...xLimits(view) },
    y: {
      label: names.length === 1 ? names[0] : title.toLowerCase(),
      anchors: marks,
      ...onAxis,
      ...yLimits(view, values),
    },
  };
}

/**
 * @param {HTMLTableElement} table
 * @param {string[]} names
 * @param {Columns} columns
 * @param {string} x
 */
function fillTable(table, names, columns, x) {
  const steps = abscissa(columns, x);
  const heads = [x, ...names].map((name) => element("th", { scope: "col" }, name));
  const rows = steps.map((step, i) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, Number.isInteger(step) ? count(step) : number(step)),
      ...names.map((name) => element("td", {}, number(columns[name][i]))),
    ),
  );
  table.replaceChildren(
    element("thead", {}, element("tr", {}, ...heads)),
    element("tbody", {}, ...rows),
  );
}

/**
 * Where the random policy and the largest reward lie; where a direction is right, or none.
 *
 * @param {string} title
 * @param {Marks} scale
 * @returns {import("../charts/chart.js").Reference[]}
 */
function referencesOf(title, { random, best }) {
  if (title.startsWith("Direction")) return [0, 1].map((value) => ({ value, label: "" }));
  if (title !== "Return") return [];
  const zero = random === null ? [] : [{ value: random.mean, label: "random" }];
  return best === null ? zero : [...zero, { value: best, label: "maximum" }];
}

/**
 * Whether a chart of losses or lengths spans decades, and says more on a logarithmic axis.
 *
 * @param {string} title
 * @param {number[]} values
 * @returns {boolean}
 */
function isDueInDecades(title, values) {
  if (!["Losses", "Gradient norms"].includes(title)) return false;
  const least = values.reduce((a, b) => Math.min(a, b), Infinity);
  const largest = values.reduce((a, b) => Math.max(a, b), 0);
  return least > 0 && largest > DECADES * least;
}
