/** The choice of what curves show: only returns have a normalised scale. */
import { element, field } from "../parts/element.js";
import { RETURNS } from "./drawing.js";

/** @import { Field, View } from "../parts/view.js" */

export class MetricChoice {
  #form;
  #view;

  /**
   * @param {HTMLFormElement} form
   * @param {View<{ metric: Field<string> }>} view
   */
  constructor(form, view) {
    this.#form = form;
    this.#view = view;
    view.onChange(() => this.offer([]));
    this.offer([]);
  }

  /**
   * Offer metrics beside those that are offered already.
   *
   * @param {string[]} names
   */
  offer(names) {
    const metric = field(this.#form, "metric", HTMLSelectElement);
    const normalization = field(this.#form, "normalization", HTMLFieldSetElement);
    const offered = new Set([...metric.options].map((option) => option.value));
    for (const name of new Set([...RETURNS, ...names, this.#view.get("metric")])) {
      if (!offered.has(name)) metric.append(element("option", { value: name }, name));
    }
    metric.value = this.#view.get("metric");
    normalization.disabled = !RETURNS.includes(metric.value);
  }
}
