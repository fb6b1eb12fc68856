/** One environment of a sweep: a figure with its chart, its caption and the same as a table. */
import { panelCaption } from "./caption.js";
import { create } from "./chart.js";
import { chartData } from "./drawing.js";
import { element, setText } from "./element.js";
import { count, number } from "./format.js";
import { Readout, sentence, valuesAt } from "./readout.js";
import { fillCurveTable } from "./curve_table.js";

const KEYS = { ArrowLeft: -1, ArrowRight: 1, PageDown: -10, PageUp: 10 };

export class Panel {
  node;
  #environment;
  #view;
  #plot;
  #chart;
  #readout = new Readout();
  #caption = element("figcaption");
  #empty = element("p", { class: "plot-empty" }, "Nothing measured yet.");
  #table = element("table", { class: "data" });
  #details;
  #panel = null;
  #data = null;

  constructor(environment, view) {
    this.#environment = environment;
    this.#view = view;
    const title = element("h3", { id: `panel-${environment}` }, environment);
    this.#plot = element(
      "div",
      {
        "class": "plot",
        "role": "slider",
        "tabindex": "0",
        "aria-label": `Learning curves of ${environment}: step to read values at`,
        "onkeydown": (event) => this.#onKey(event),
      },
      this.#empty,
      this.#readout.node,
    );
    this.#details = this.#buildDetails();
    this.node = element(
      "figure",
      { "class": "panel", "aria-labelledby": title.id },
      title,
      this.#plot,
      this.#caption,
      this.#details,
    );
    this.#chart = create(this.#plot, { group: "sweep", onCursor: (index) => this.#read(index) });
    this.#announce(null);
  }

  /** Show the service's answer for this environment under the view as it is now. */
  update({ panel, known, axes }) {
    this.#panel = panel;
    this.#data = chartData(panel, known, this.#view, axes);
    this.#chart.update(this.#data);
    this.#empty.hidden = this.#data.curves.some((curve) => curve.x.length > 0);
    setText(this.#caption, panelCaption(panel, this.#view, this.#data));
    this.#details.open = this.#view.get("table").includes(this.#environment);
    this.#fillTable();
    this.#read(this.#chart.cursorIndex);
  }

  #buildDetails() {
    const label = `Values of the curves of ${this.#environment}`;
    const scroller = element("div", { "class": "scroller", "role": "region", "tabindex": "0" });
    scroller.setAttribute("aria-label", label);
    scroller.append(this.#table);
    const details = element("details", {}, element("summary", {}, "View as table"), scroller);
    details.addEventListener("toggle", () => {
      const others = this.#view.get("table").filter((name) => name !== this.#environment);
      const open = details.open ? [...others, this.#environment] : others;
      if (String(open) !== String(this.#view.get("table"))) this.#view.set({ table: open });
      this.#fillTable();
    });
    return details;
  }

  #fillTable() {
    if (!this.#details.open || this.#panel === null) return;
    const hidden = this.#view.get("hide");
    const curves = this.#panel.curves.filter((curve) => !hidden.includes(curve.label));
    fillCurveTable(this.#table, curves, this.#view.get("x"), this.#view.get("metric"));
  }

  /** The cursor is at an index of the chart's steps, or nowhere. */
  #read(index) {
    const x = index === null ? undefined : this.#chart.xs[index];
    if (x === undefined) {
      this.#readout.hide();
      this.#announce(null);
      return;
    }
    const step = `${this.#view.get("x")} ${Number.isInteger(x) ? count(x) : number(x)}`;
    const values = valuesAt(this.#data.curves, x);
    this.#readout.show(step, values, this.#chart.cursorLeft, this.#plot.clientWidth);
    this.#announce(x, sentence(step, values));
  }

  #announce(x, text = "no step chosen") {
    const steps = this.#chart.xs;
    this.#plot.setAttribute("aria-valuemin", steps[0] ?? 0);
    this.#plot.setAttribute("aria-valuemax", steps.at(-1) ?? 0);
    this.#plot.setAttribute("aria-valuenow", x ?? steps[0] ?? 0);
    this.#plot.setAttribute("aria-valuetext", text);
  }

  #onKey(event) {
    const last = this.#chart.xs.length - 1;
    const here = this.#chart.cursorIndex ?? -1;
    let index;
    if (event.key in KEYS) index = Math.max(0, Math.min(last, here + KEYS[event.key]));
    else if (event.key === "Home") index = 0;
    else if (event.key === "End") index = last;
    else if (event.key === "Escape") index = -1;
    else return;
    event.preventDefault();
    this.#chart.setCursor(index);
  }
}
