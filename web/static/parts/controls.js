/** A view's inputs: each names its field of the view in `data-field`. */

/** @import { View } from "./view.js" */
/** @typedef {HTMLInputElement | HTMLSelectElement} Input */

export class Controls {
  #form;
  #view;

  /**
   * @param {HTMLFormElement} form
   * @param {View<any>} view
   */
  constructor(form, view) {
    this.#form = form;
    this.#view = view;
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("input", (event) => this.#onInput(/** @type {Input} */ (event.target)));
    form.addEventListener("change", (event) => this.#onChange(/** @type {Input} */ (event.target)));
    this.#reset?.addEventListener("click", () => view.reset());
    view.onChange(() => this.update());
    this.update();
  }

  /** Let the inputs say what the view is. */
  update() {
    /** @type {NodeListOf<Input>} */
    const inputs = this.#form.querySelectorAll("[data-field]");
    for (const input of inputs) {
      const value = this.#view.get(String(input.dataset.field));
      if (isChoice(input)) input.checked = input.type === "radio" ? input.value === value : value;
      else input.value = value ?? "";
    }
    const output = this.#form.elements.namedItem("smoothing_value");
    if (output instanceof HTMLOutputElement) output.value = this.#view.get("smoothing") || "off";
    if (this.#reset) this.#reset.hidden = this.#view.isInitial;
  }

  /** The button that resets the view, where there is one. */
  get #reset() {
    const button = this.#form.elements.namedItem("reset");
    return button instanceof HTMLButtonElement ? button : null;
  }

  /** @param {Input} input */
  #onInput(input) {
    const { field } = input.dataset;
    if (field === undefined || input.type === "number") return;
    if (isChoice(input) && input.type === "checkbox") this.#view.set({ [field]: input.checked });
    else if (typeof this.#view.get(field) === "number") this.#view.set({ [field]: Number(input.value) });
    else this.#view.set({ [field]: input.value });
  }

  /**
   * A number counts when it is whole: "0." on the way to 0.5 is none.
   *
   * @param {Input} input
   */
  #onChange(input) {
    const { field } = input.dataset;
    if (field === undefined || input.type !== "number") return;
    this.#view.set({ [field]: input.value === "" ? null : Number(input.value) });
  }
}

/**
 * @param {Input} input
 * @returns {input is HTMLInputElement}
 */
function isChoice(input) {
  return input instanceof HTMLInputElement && ["checkbox", "radio"].includes(input.type);
}
