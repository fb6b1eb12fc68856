/** One environment of a sweep: a figure of its learning curves. */
import { panelCaption } from "./caption.js";
import { fillCurveTable } from "./curve_table.js";
import { chartData } from "./drawing.js";
import { ChartFigure, remembersTable } from "./figure.js";

/**
 * @import { Identities } from "../parts/identity.js"
 * @import { View } from "../parts/view.js"
 * @import { Axes, Fields } from "./drawing.js"
 *
 * @typedef {{ panel: Api.Panel, known: Identities, axes: Axes }} Shown
 */

export class Panel {
  #environment;
  #view;
  #figure;

  /**
   * @param {string} environment
   * @param {View<Fields>} view
   */
  constructor(environment, view) {
    this.#environment = environment;
    this.#view = view;
    const texts = { title: environment, label: `Learning curves of ${environment}` };
    this.#figure = new ChartFigure(texts, "curves", remembersTable(view, environment));
  }

  get node() {
    return this.#figure.node;
  }

  /**
   * Show the service's answer for this environment under the view as it is now.
   *
   * @param {Shown} shown
   */
  update({ panel, known, axes }) {
    const view = this.#view;
    const data = chartData(panel, known, view, axes);
    const curves = panel.curves.filter((curve) => !view.get("hide").includes(curve.label));
    const texts = { caption: panelCaption(panel, view, data), abscissa: view.get("x") };
    this.#figure.update(data, texts, {
      isOpen: view.get("table").includes(this.#environment),
      fill: (table) => fillCurveTable(table, curves, view.get("x"), view.get("metric")),
    });
  }
}
