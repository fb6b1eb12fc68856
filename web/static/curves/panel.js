/** One environment of a sweep: a figure of its learning curves. */
import { panelCaption } from "./caption.js";
import { fillCurveTable } from "./curve_table.js";
import { chartData } from "./drawing.js";
import { ChartFigure, remembersTable } from "../charts/figure.js";

/**
 * @import { Identities } from "../parts/identity.js"
 * @import { View } from "../parts/view.js"
 * @import { Axes, Fields } from "./drawing.js"
 *
 * @typedef {object} Shown
 * @property {Api.Panel} panel
 * @property {Identities} known
 * @property {Axes} axes
 * @property {Set<string>} hidden   labels
 *
 * @typedef {{ environment: string, x: number } | null} Reading   where the cursor is
 */

export class Panel {
  #environment;
  #view;
  #figure;

  /**
   * @param {string} environment
   * @param {View<Fields>} view
   * @param {(reading: Reading) => void} onRead
   */
  constructor(environment, view, onRead) {
    this.#environment = environment;
    this.#view = view;
    const texts = { title: environment, label: `Learning curves of ${environment}` };
    this.#figure = new ChartFigure(texts, "curves", {
      onToggle: remembersTable(view, environment),
      onZoom: (from, to) => view.set({ from, to }),
      onRead: (x) => {
        if (x === null) onRead(null);
        else if (this.node.matches(":hover, :focus-within")) onRead({ environment, x });
      },
    });
  }

  get node() {
    return this.#figure.node;
  }

  /**
   * Show the service's answer for this environment under the view as it is now.
   *
   * @param {Shown} shown
   */
  update({ panel, known, axes, hidden }) {
    const view = this.#view;
    const data = chartData(panel, known, view, axes, hidden);
    const curves = panel.curves.filter((curve) => !hidden.has(curve.label));
    const texts = { caption: panelCaption(panel, view, data, hidden), abscissa: view.get("x") };
    this.#figure.update(data, texts, {
      isOpen: view.get("table").includes(this.#environment),
      fill: (table) => fillCurveTable(table, curves, view.get("x"), view.get("metric")),
    });
  }
}
