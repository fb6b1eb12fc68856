/** A chart with its title, the values at its cursor, its caption, and the same as a table. */
import { element, setText } from "../parts/element.js";
import { count, number } from "../texts/format.js";
import { Chart } from "./chart.js";
import { Readout, sentence, valuesAt } from "./readout.js";

let made = 0; // figures so far, which names their headings
const KEYS = new Map([
  ["ArrowLeft", -1],
  ["ArrowRight", 1],
  ["PageDown", -10],
  ["PageUp", 10],
]);

/**
 * @import { Data } from "./chart.js"
 * @import { Field, View } from "../parts/view.js"
 *
 * What a figure tells of what is done to it.
 *
 * @typedef {object} Listener
 * @property {(isOpen: boolean) => void} onToggle   the table was opened or closed
 * @property {(from: number | null, to: number | null) => void} [onZoom]   a part of the x axis was
 *   marked; null twice: all of it
 * @property {(x: number | null) => void} [onRead]   the cursor is at a step, or nowhere
 */

export class ChartFigure {
  /** @type {HTMLElement} */
  node;
  #plot;
  #chart;
  #readout = new Readout();
  #caption = element("figcaption");
  #empty = element("p", { class: "plot-empty" }, "Nothing measured yet.");
  #table = element("table", { class: "data" });
  #details;
  #abscissa = "";
  #onRead;
  #fillTable = () => {};
  /** @type {Data | null} */
  #data = null;

  /**
   * @param {{ title: string, label: string }} texts the heading, and what the chart is to those who
   *   hear it
   * @param {string} group charts of one group share their cursor
   * @param {Listener} listener
   */
  constructor({ title, label }, group, { onToggle, onZoom, onRead = () => {} }) {
    this.#onRead = onRead;
    const heading = element("h3", { id: `figure-${made++}` }, title);
    this.#plot = element(
      "div",
      {
        "class": "plot",
        "role": "slider",
        "tabindex": "0",
        "aria-label": `${label}: step to read values at`,
        "onkeydown": (event) => this.#onKey(event),
      },
      this.#empty,
      this.#readout.node,
    );
    this.#details = this.#buildDetails(`Values of ${label}`, onToggle);
    this.node = element(
      "figure",
      { "class": "panel", "aria-labelledby": heading.id },
      heading,
      this.#plot,
      this.#caption,
      this.#details,
    );
    const onCursor = (/** @type {number | null} */ index) => this.#read(index);
    this.#chart = new Chart(this.#plot, { group, onCursor, onZoom });
    this.#announce(null);
  }

  /**
   * Show data.
   *
   * @param {Data} data
   * @param {{ caption: string, abscissa: string }} texts
   * @param {{ isOpen: boolean, fill: (table: HTMLTableElement) => void }} twin the table, which is
   *   filled while it is open
   */
  update(data, { caption, abscissa }, { isOpen, fill }) {
    this.#data = data;
    this.#abscissa = abscissa;
    this.#fillTable = () => {
      if (this.#details.open) fill(this.#table);
    };
    this.#chart.update(data);
    this.#empty.hidden = data.curves.some((curve) => curve.x.length > 0);
    setText(this.#caption, caption);
    this.#details.open = isOpen;
    this.#fillTable();
    this.#read(this.#chart.cursorIndex);
  }

  /**
   * @param {string} label
   * @param {(isOpen: boolean) => void} onToggle
   * @returns {HTMLDetailsElement}
   */
  #buildDetails(label, onToggle) {
    const scroller = element("div", { "class": "scroller", "role": "region", "tabindex": "0" });
    scroller.setAttribute("aria-label", label);
    scroller.append(this.#table);
    const details = element("details", {}, element("summary", {}, "View as table"), scroller);
    details.addEventListener("toggle", () => {
      onToggle(details.open);
      this.#fillTable();
    });
    return details;
  }

  /**
   * The cursor is at an index of the chart's steps, or nowhere.
   *
   * @param {number | null} index
   */
  #read(index) {
    const x = index === null ? undefined : this.#chart.xs[index];
    this.#onRead(x ?? null);
    if (x === undefined || this.#data === null) {
      this.#readout.hide();
      this.#announce(null);
      return;
    }
    const step = `${this.#abscissa} ${Number.isInteger(x) ? count(x) : number(x)}`;
    const values = valuesAt(this.#data.curves, x);
    this.#readout.show(step, values, this.#chart.cursorLeft, this.#plot.clientWidth);
    this.#announce(x, sentence(step, values));
  }

  /**
   * @param {number | null} x
   * @param {string} [text]
   */
  #announce(x, text = "no step chosen") {
    const steps = this.#chart.xs;
    this.#plot.setAttribute("aria-valuemin", String(steps[0] ?? 0));
    this.#plot.setAttribute("aria-valuemax", String(steps.at(-1) ?? 0));
    this.#plot.setAttribute("aria-valuenow", String(x ?? steps[0] ?? 0));
    this.#plot.setAttribute("aria-valuetext", text);
  }

  /** @param {KeyboardEvent} event */
  #onKey(event) {
    const last = this.#chart.xs.length - 1;
    const here = this.#chart.cursorIndex ?? -1;
    let index;
    const jump = KEYS.get(event.key);
    if (jump !== undefined) index = Math.max(0, Math.min(last, here + jump));
    else if (event.key === "Home") index = 0;
    else if (event.key === "End") index = last;
    else if (event.key === "Escape") index = -1;
    else return;
    event.preventDefault();
    this.#chart.setCursor(index);
  }
}

/**
 * What a figure's table does to the view's list of open tables, for `onToggle`.
 *
 * @param {View<{ table: Field<string[]> }>} view
 * @param {string} name
 * @returns {(isOpen: boolean) => void}
 */
export function remembersTable(view, name) {
  return (isOpen) => {
    const others = view.get("table").filter((each) => each !== name);
    const open = isOpen ? [...others, name] : others;
    if (String(open) !== String(view.get("table"))) view.set({ table: open });
  };
}
