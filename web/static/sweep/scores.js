/** What each entry of a sweep reached in each task, the best in bold, sortable. */
import { address, get } from "../connection/api.js";
import { element, setText } from "../parts/element.js";
import { identities } from "../parts/identity.js";
import { swatch } from "../parts/swatch.js";
import { statusTexts } from "../texts/sweep.js";

const at = (name) => document.getElementById(name);

export class ScoreTable {
  #id;
  #view;
  #entries;
  #answer = null;

  /**
   * @param entries () => those of the sweep, as identity.js takes them
   * @param refetch () => void; asks for `load` to be called, for another scale or score
   */
  constructor(id, view, entries, refetch) {
    this.#id = id;
    this.#view = view;
    this.#entries = entries;
    view.addEventListener("change", ({ detail: fields }) => {
      if (fields.includes("scale") || fields.includes("score")) refetch();
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
    return {
      score: this.#view.get("score"),
      normalized: this.#view.get("scale") === "normalized",
    };
  }

  #draw() {
    if (this.#answer === null) return;
    const { environments, definition, decimals } = this.#answer;
    const known = identities(this.#entries());
    at("score-table").replaceChildren(
      element("caption", { class: "visually-hidden" }, "Scores, mean ± standard deviation"),
      element("thead", {}, this.#head(environments)),
      element("tbody", {}, ...this.#sorted().map((row) => bodyRow(row, decimals, known))),
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

  /** The rows as submitted, or the best of the chosen task first, cells that lack runs after those. */
  #sorted() {
    const { environments, rows } = this.#answer;
    const column = environments.indexOf(this.#view.get("sort"));
    if (column < 0) return rows;
    const rank = ({ entries }) => {
      const { n = 0, runs = 1, mean = null } = entries[column] ?? {};
      return [n === runs ? 1 : 0, mean ?? -Infinity];
    };
    const after = ([whole, mean], [other, its]) => other - whole || (its > mean) - (its < mean);
    return [...rows].sort((a, b) => after(rank(a), rank(b)));
  }
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

/** "n 16", or "n 5 of 6, 1 diverged". */
function countText({ n, runs, unfinished }) {
  if (n === runs) return `n ${n}`;
  return [`n ${n} of ${runs}`, ...statusTexts(unfinished)].join(", ");
}
