/** The legend over all panels: hide a curve with its checkbox, show it alone with "only". */
import { element, keyed, setText } from "../parts/element.js";
import { swatch } from "../parts/swatch.js";
import { counted } from "../texts/format.js";

export class Legend {
  #view;
  #show;
  #labels = [];

  constructor(list, view) {
    this.#view = view;
    this.#show = keyed(
      list,
      ({ label, colour }) => `${label} ${colour}`,
      (identity) => this.#entry(identity),
    );
  }

  /** @param known from identity.js; those are shown that have runs in the panels */
  update(known, panels) {
    const runs = new Map();
    for (const curve of panels.flatMap((panel) => panel.curves)) {
      runs.set(curve.label, (runs.get(curve.label) ?? 0) + curve.runs);
    }
    const shown = [...known.values()].filter(({ label }) => runs.has(label));
    this.#labels = shown.map(({ label }) => label);
    this.#show(shown.map((identity) => ({ ...identity, runs: runs.get(identity.label) })));
  }

  #entry({ label, colour, dash }) {
    const box = element("input", { type: "checkbox" });
    box.addEventListener("change", () => this.#toggle(label));
    const runs = element("span", { class: "muted" });
    const only = element("button", { type: "button", class: "quiet" });
    only.addEventListener("click", () => this.#solo(label));
    const name = element("label", {}, box, swatch({ colour, dash }), label, " ", runs);
    const update = (identity) => {
      box.checked = !this.#view.get("hide").includes(label);
      setText(runs, counted(identity.runs, "run"));
      setText(only, this.#isSolo(label) ? "all" : "only");
      only.setAttribute("aria-label", this.#isSolo(label) ? "Show all" : `Show only ${label}`);
    };
    return { node: element("li", {}, name, only), update };
  }

  #toggle(label) {
    const hidden = this.#view.get("hide");
    const others = hidden.filter((each) => each !== label);
    this.#view.set({ hide: others.length < hidden.length ? others : [...hidden, label] });
  }

  #solo(label) {
    const others = this.#labels.filter((each) => each !== label);
    this.#view.set({ hide: this.#isSolo(label) ? [] : others });
  }

  #isSolo(label) {
    const hidden = this.#view.get("hide");
    return (
      this.#labels.length > 1 &&
      !hidden.includes(label) &&
      this.#labels.every((each) => each === label || hidden.includes(each))
    );
  }
}
