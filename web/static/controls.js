/** The view's inputs: each names its field of the view in `data-field`. */
import { element } from "./element.js";
import { RETURNS } from "./drawing.js";

export class Controls {
  #form;
  #view;

  constructor(form, view) {
    this.#form = form;
    this.#view = view;
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("input", (event) => this.#onInput(event.target));
    form.elements.reset.addEventListener("click", () => view.reset());
    view.addEventListener("change", () => this.update());
    this.update();
  }

  /** Offer metrics beside those that are offered already. */
  offerMetrics(names) {
    const select = this.#form.elements.metric;
    const offered = new Set([...select.options].map((option) => option.value));
    const wanted = new Set([...RETURNS, ...names, this.#view.get("metric")]);
    for (const name of wanted) {
      if (!offered.has(name)) select.append(element("option", { value: name }, name));
    }
    select.value = this.#view.get("metric");
  }

  /** Let the inputs say what the view is. */
  update() {
    this.offerMetrics([]);
    for (const input of this.#form.querySelectorAll("[data-field]")) {
      const value = this.#view.get(input.dataset.field);
      if (input.type === "checkbox") input.checked = value;
      else if (input.type === "radio") input.checked = input.value === value;
      else input.value = value;
    }
    const { normalization, smoothing_value: output, reset } = this.#form.elements;
    normalization.disabled = !RETURNS.includes(this.#view.get("metric"));
    output.value = this.#view.get("smoothing") > 0 ? this.#view.get("smoothing") : "off";
    reset.hidden = this.#view.isInitial;
  }

  #onInput(input) {
    const { field } = input.dataset;
    if (field === undefined) return;
    if (input.type === "checkbox") this.#view.set({ [field]: input.checked });
    else if (input.type === "range") this.#view.set({ [field]: Number(input.value) });
    else this.#view.set({ [field]: input.value });
  }
}
