/** A view's inputs: each names its field of the view in `data-field`. */

export class Controls {
  #form;
  #view;

  constructor(form, view) {
    this.#form = form;
    this.#view = view;
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("input", (event) => this.#onInput(event.target));
    form.elements.reset?.addEventListener("click", () => view.reset());
    view.addEventListener("change", () => this.update());
    this.update();
  }

  /** Let the inputs say what the view is. */
  update() {
    for (const input of this.#form.querySelectorAll("[data-field]")) {
      const value = this.#view.get(input.dataset.field);
      if (input.type === "checkbox") input.checked = value;
      else if (input.type === "radio") input.checked = input.value === value;
      else input.value = value;
    }
    const { smoothing_value: output, reset } = this.#form.elements;
    if (output) output.value = this.#view.get("smoothing") > 0 ? this.#view.get("smoothing") : "off";
    if (reset) reset.hidden = this.#view.isInitial;
  }

  #onInput(input) {
    const { field } = input.dataset;
    if (field === undefined) return;
    if (input.type === "checkbox") this.#view.set({ [field]: input.checked });
    else if (input.type === "range") this.#view.set({ [field]: Number(input.value) });
    else this.#view.set({ [field]: input.value });
  }
}
