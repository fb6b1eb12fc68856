/**
 * The legend beside all panels: it finds curves by their names, puts the highest first, says what
 * each is worth where the cursor is, hides one with its checkbox and shows it alone with "only".
 */
import { Controls } from "../parts/controls.js";
import { at, element, keyed, setText } from "../parts/element.js";
import { swatch } from "../parts/swatch.js";
import { count, counted, number } from "../texts/format.js";
import { standing } from "./standing.js";

/**
 * @import { Identities, Identity } from "../parts/identity.js"
 * @import { View } from "../parts/view.js"
 * @import { Fields } from "./drawing.js"
 * @import { Reading } from "./panel.js"
 *
 * @typedef {Identity & { runs: number, isShown: boolean, value?: number }} Shown
 */

export class Legend {
  #view;
  #show;
  #list = at("legend");
  /** @type {Shown[]} */
  #entries = [];
  /** @type {Api.Panel[]} */
  #panels = [];
  /** @type {Reading} */
  #reading = null;
  #isAwaited = false; // whether values are to be written at the next frame

  /** @param {View<Fields>} view */
  constructor(view) {
    this.#view = view;
    new Controls(at("legend-controls", HTMLFormElement), view);
    this.#show = keyed(
      this.#list,
      (/** @type {Shown} */ { label, colour }) => `${label} ${colour}`,
      (identity) => this.#entry(identity),
    );
  }

  /**
   * @param {Identities} known those of them are listed that have runs in the panels
   * @param {Api.Panel[]} panels
   * @param {Set<string>} hidden labels
   */
  update(known, panels, hidden) {
    /** @type {Map<string, number>} */
    const runs = new Map();
    for (const curve of panels.flatMap((panel) => panel.curves)) {
      runs.set(curve.label, (runs.get(curve.label) ?? 0) + curve.runs);
    }
    this.#panels = panels;
    this.#entries = [...known.values()].flatMap((identity) => {
      const { label } = identity;
      const number = runs.get(label);
      return number ? [{ ...identity, runs: number, isShown: !hidden.has(label) }] : [];
    });
    this.#write();
  }

  /**
   * The cursor is at a step of a panel, or nowhere.
   *
   * @param {Reading} reading
   */
  read(reading) {
    this.#reading = reading;
    if (this.#isAwaited) return;
    this.#isAwaited = true;
    requestAnimationFrame(() => {
      this.#isAwaited = false;
      this.#write();
    });
  }

  #write() {
    const values = standing(this.#panels, this.#reading, this.#view);
    // What has the focus must not move away under it.
    if (this.#view.get("order") === "value" && !this.#list.matches(":focus-within")) {
      const rank = (/** @type {Shown} */ { label }) => values.get(label) ?? -1e300;
      this.#entries.sort((a, b) => Number(b.isShown) - Number(a.isShown) || rank(b) - rank(a));
    }
    this.#show(this.#entries.map((each) => ({ ...each, value: values.get(each.label) })));
    setText(at("legend-step"), this.#whereText());
  }

  /** Of what the values are, and how many of the curves are shown. */
  #whereText() {
    const shown = this.#entries.filter(({ isShown }) => isShown).length;
    const some = shown < this.#entries.length ? `${shown} of ${counted(this.#entries.length, "curve")}. ` : "";
    if (this.#reading !== null) return `${some}${this.#reading.environment}, ${count(this.#reading.x)}:`;
    return `${some}${this.#panels.length > 1 ? "Latest, mean over tasks:" : "Latest:"}`;
  }

  /**
   * @param {Shown} identity
   * @returns {{ node: HTMLElement, update: (identity: Shown) => void }}
   */
  #entry({ label, colour, dash }) {
    const box = element("input", { type: "checkbox" });
    box.addEventListener("change", () => this.#toggle(label));
    const runs = element("span", { class: "muted" });
    const value = element("span", { class: "value" });
    const only = element("button", { type: "button", class: "quiet" });
    only.addEventListener("click", () => this.#solo(label));
    const text = element("span", { class: "name" }, label, " ", runs);
    const name = element("label", {}, box, swatch({ colour, dash }), text);
    const node = element("li", {}, name, value, only);
    const update = (/** @type {Shown} */ shown) => {
      box.checked = !this.#view.get("hide").includes(label);
      node.classList.toggle("left-out", box.checked && !shown.isShown);
      setText(runs, counted(shown.runs, "run"));
      setText(value, shown.value === undefined ? "" : number(shown.value));
      setText(only, this.#isSolo(label) ? "all" : "only");
      only.setAttribute("aria-label", this.#isSolo(label) ? "Show all" : `Show only ${label}`);
    };
    return { node, update };
  }

  /** @param {string} label */
  #toggle(label) {
    const hidden = this.#view.get("hide");
    const others = hidden.filter((each) => each !== label);
    this.#view.set({ hide: others.length < hidden.length ? others : [...hidden, label] });
  }

  /** @param {string} label */
  #solo(label) {
    const others = this.#entries.map((each) => each.label).filter((each) => each !== label);
    this.#view.set({ hide: this.#isSolo(label) ? [] : others });
  }

  /**
   * @param {string} label
   * @returns {boolean}
   */
  #isSolo(label) {
    const hidden = this.#view.get("hide");
    return (
      this.#entries.length > 1 &&
      !hidden.includes(label) &&
      this.#entries.every((each) => each.label === label || hidden.includes(each.label))
    );
  }
}
