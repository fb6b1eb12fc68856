/** The legend over all panels: hide a curve with its checkbox, show it alone with "only". */
import { element, keyed, setText } from "../parts/element.js";
import { swatch } from "../parts/swatch.js";
import { counted } from "../texts/format.js";

/**
 * @import { Identities, Identity } from "../parts/identity.js"
 * @import { Field, View } from "../parts/view.js"
 *
 * @typedef {Identity & { runs: number }} Shown
 */

export class Legend {
  #view;
  #show;
  /** @type {string[]} */
  #labels = [];

  /**
   * @param {HTMLElement} list
   * @param {View<{ hide: Field<string[]> }>} view
   */
  constructor(list, view) {
    this.#view = view;
    this.#show = keyed(
      list,
      (/** @type {Shown} */ { label, colour }) => `${label} ${colour}`,
      (identity) => this.#entry(identity),
    );
  }

  /**
   * @param {Identities} known those of them are shown that have runs in the panels
   * @param {Api.Panel[]} panels
   */
  update(known, panels) {
    /** @type {Map<string, number>} */
    const runs = new Map();
    for (const curve of panels.flatMap((panel) => panel.curves)) {
      runs.set(curve.label, (runs.get(curve.label) ?? 0) + curve.runs);
    }
    const shown = [...known.values()].filter(({ label }) => runs.has(label));
    this.#labels = shown.map(({ label }) => label);
    this.#show(shown.map((identity) => ({ ...identity, runs: runs.get(identity.label) ?? 0 })));
  }

  /**
   * @param {Shown} identity
   * @returns {{ node: HTMLElement, update: (identity: Shown) => void }}
   */
  #entry({ label, colour, dash }) {
    const box = element("input", { type: "checkbox" });
    box.addEventListener("change", () => this.#toggle(label));
    const runs = element("span", { class: "muted" });
    const only = element("button", { type: "button", class: "quiet" });
    only.addEventListener("click", () => this.#solo(label));
    const name = element("label", {}, box, swatch({ colour, dash }), label, " ", runs);
    const update = (/** @type {Shown} */ identity) => {
      box.checked = !this.#view.get("hide").includes(label);
      setText(runs, counted(identity.runs, "run"));
      setText(only, this.#isSolo(label) ? "all" : "only");
      only.setAttribute("aria-label", this.#isSolo(label) ? "Show all" : `Show only ${label}`);
    };
    return { node: element("li", {}, name, only), update };
  }

  /** @param {string} label */
  #toggle(label) {
    const hidden = this.#view.get("hide");
    const others = hidden.filter((each) => each !== label);
    this.#view.set({ hide: others.length < hidden.length ? others : [...hidden, label] });
  }

  /** @param {string} label */
  #solo(label) {
    const others = this.#labels.filter((each) => each !== label);
    this.#view.set({ hide: this.#isSolo(label) ? [] : others });
  }

  /**
   * @param {string} label
   * @returns {boolean}
   */
  #isSolo(label) {
    const hidden = this.#view.get("hide");
    return (
      this.#labels.length > 1 &&
      !hidden.includes(label) &&
      this.#labels.every((each) => each === label || hidden.includes(each))
    );
  }
}
