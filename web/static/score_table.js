/** Table 1: what each curve of a sweep reached in each task, the best in bold, sortable. */
import { address, get } from "./api.js";
import { element, setText } from "./element.js";
import { RETURNS } from "./drawing.js";
import { identities } from "./identity.js";
import { swatch } from "./swatch.js";

const at = (name) => document.getElementById(name);

export class ScoreTable {
  #id;
  #view;
  #answer = null;

  /** @param refetch () => void; asks for `load` to be called, for another scale or metric */
  constructor(id, view, refetch) {
    this.#id = id;
    this.#view = view;
    view.addEventListener("change", ({ detail: fields }) => {
      if (fields.includes("scale") || fields.includes("metric")) refetch();
      else this.#draw();
    });
    document.addEventListener("themechange", () => this.#draw());
  }

  async load(signal) {
    const asked = this.#question();
    this.#answer = await get(`/sweeps/${this.#id}/table`, asked, signal);
    for (const format of ["csv", "latex", "markdown"]) {
      const link = at(`table-${format}`);
      link.href = address(`/sweeps/${this.#id}/table`, { ...asked, format });
      link.download = `sweep-${this.#id}-table.${{ latex: "tex", markdown: "md" }[format] ?? format}`;
    }
    this.#draw();
  }

  #question() {
    const metric = this.#view.get("metric");
    return {
      metric: RETURNS.includes(metric) && metric !== RETURNS[0] ? metric : "return_history",
      normalized: this.#view.get("scale") === "normalized",
    };
  }

  #draw() {
    if (this.#answer === null) return;
    const { environments, rows, definition, decimals } = this.#answer;
    at("score-table").replaceChildren(
      element("caption", { class: "visually-hidden" }, "Final returns, mean ± standard deviation"),
      element("thead", {}, this.#head(environments)),
      element("tbody", {}, ...this.#sorted().map((row) => bodyRow(row, decimals, swatches(rows)))),
    );
    setText(at("score-definition"), definition);
  }

  #head(environments) {
    const sorted = this.#view.get("sort");
    const cells = environments.map((environment) => {
      const button = element("button", { type: "button", class: "sorter" }, environment);
      button.addEventListener("click", () => {
        this.#view.set({ sort: sorted === environment ? "" : environment });
        at("score-table").querySelectorAll(".sorter")[environments.indexOf(environment)].focus();
      });
      const cell = element("th", { scope: "col", class: "number" }, button);
      if (sorted === environment) cell.setAttribute("aria-sort", "descending");
      return cell;
    });
    return element("tr", {}, element("th", { scope: "col" }, "Learner"), ...cells);
  }

  /** The rows as submitted, or the best of the chosen task first. */
  #sorted() {
    const { environments, rows } = this.#answer;
    const column = environments.indexOf(this.#view.get("sort"));
    if (column < 0) return rows;
    const value = (row) => row.entries[column]?.mean ?? -Infinity;
    return [...rows].sort((a, b) => (value(b) > value(a)) - (value(b) < value(a)));
  }
}

/** The curves' own colours and dashes, by label. */
function swatches(rows) {
  const curves = rows.map(({ label, entries }) => {
    const [{ algorithm }] = entries.filter((entry) => entry !== null);
    return { label, algorithm, runs: 0 };
  });
  return identities([{ curves }]);
}

function bodyRow({ label, entries }, decimals, known) {
  const name = element("th", { scope: "row" }, swatch(known.get(label)), label);
  return element("tr", {}, name, ...entries.map((entry) => valueCell(entry, decimals)));
}

function valueCell(entry, decimals) {
  if (entry === null || entry.mean === null) {
    return element("td", { class: "number muted" }, entry === null ? "" : `– (${countText(entry)})`);
  }
  const fixed = (value) => value.toFixed(decimals).replace("-", "−");
  const text = entry.std === null ? fixed(entry.mean) : `${fixed(entry.mean)} ± ${fixed(entry.std)}`;
  const note = element("small", { class: "muted" }, countText(entry));
  const value = element(entry.is_best ? "strong" : "span", {}, text);
  return element("td", { class: "number" }, value, note);
}

/** "n 16", and how many of the runs still go on or gave no number. */
function countText({ n, runs, ended }) {
  if (n < runs) return `n ${n} of ${runs}`;
  return ended < runs ? `n ${n}, ${runs - ended} going on` : `n ${n}`;
}
