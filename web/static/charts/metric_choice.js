/** The choice of what curves show: only returns have a normalised scale. */
import { element } from "../parts/element.js";
import { RETURNS } from "./drawing.js";

export class MetricChoice {
  #form;
  #view;

  constructor(form, view) {
    this.#form = form;
    this.#view = view;
    view.addEventListener("change", () => this.offer([]));
    this.offer([]);
  }

  /** Offer metrics beside those that are offered already. */
  offer(names) {
    const { metric, normalization } = this.#form.elements;
    const offered = new Set([...metric.options].map((option) => option.value));
    for (const name of new Set([...RETURNS, ...names, this.#view.get("metric")])) {
      if (!offered.has(name)) metric.append(element("option", { value: name }, name));
    }
    metric.value = this.#view.get("metric");
    normalization.disabled = !RETURNS.includes(metric.value);
  }
}
