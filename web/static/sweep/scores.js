/** What each entry of a sweep reached in each task, the best in bold, sortable. */
import { address, get } from "../connection/api.js";
import { at, element, setText, within } from "../parts/element.js";
import { identities, identityOf } from "../parts/identity.js";
import { swatch } from "../parts/swatch.js";
import { statusTexts } from "../texts/sweep.js";

const ENDINGS = { csv: "csv", latex: "tex", markdown: "md" };

/**
 * @import { Entry, Identities } from "../parts/identity.js"
 * @import { Field, View } from "../parts/view.js"
 *
 * @typedef {object} Fields
 * @property {Field<"final" | "return_history" | "area">} score
 * @property {Field<"normalized" | "raw">} scale
 * @property {Field<string>} sort
 *
 * @typedef {Api.ScoreTable["rows"][number]} Row
 * @typedef {NonNullable<Row["entries"][number]>} Standing
 */

export class ScoreTable {
  #id;
  #view;
  #entries;
  #onAnswer;
  /** @type {Api.ScoreTable | null} */
  #answer = null;

  /**
   * @param {() => string} id of the sweep, or of several that are joined
   * @param {View<Fields>} view
   * @param {() => Entry[]} entries those of them
   * @param {() => void} refetch asks for `load` to be called, for another scale or score
   * @param {(answer: Api.ScoreTable) => void} onAnswer
   */
  constructor(id, view, entries, refetch, onAnswer) {
    this.#onAnswer = onAnswer;
    this.#id = id;
    this.#view = view;
    this.#entries = entries;
    view.onChange((fields) => {
      if (fields.includes("scale") || fields.includes("score")) refetch();
      else this.#draw();
    });
    document.addEventListener("themechange", () => this.#draw());
  }

  /** @param {AbortSignal} signal */
  async load(signal) {
    const [id, asked] = [this.#id(), this.#question()];
    const answer = await get(`/sweeps/${id}/table`, asked, signal);
    if (id !== this.#id()) return; // others are compared by now
    this.#answer = answer;
    for (const [format, ending] of Object.entries(ENDINGS)) {
      const link = at(`table-${format}`, HTMLAnchorElement);
      link.href = address(`/sweeps/${id}/table`, { ...asked, format });
      link.download = `sweep-${id}-table.${ending}`;
    }
    this.#draw();
    this.#onAnswer(this.#answer);
  }

  #question() {
    return {
      score: this.#view.get("score"),
      normalized: this.#view.get("scale") === "normalized",
    };
  }

  #draw() {
    if (this.#answer?.sweep !== this.#id()) return;
    const { environments, rows, definition, decimals } = this.#answer;
    const known = identities(this.#entries());
    const sorted = this.#sorted(rows, environments);
    at("score-table").replaceChildren(
      element("caption", { class: "visually-hidden" }, "Scores, mean ± standard deviation"),
      element("thead", {}, this.#head(environments)),
      element("tbody", {}, ...sorted.map((row) => bodyRow(row, decimals, known))),
    );
    setText(at("score-definition"), definition);
  }

  /**
   * @param {string[]} environments
   * @returns {HTMLElement}
   */
  #head(environments) {
    const sorted = this.#view.get("sort");
    const cells = environments.map((environment) => {
      const button = element(
        "button",
        { "type": "button", "class": "sorter", "data-task": environment },
        environment,
      );
      button.addEventListener("click", () => {
        this.#view.set({ sort: sorted === environment ? "" : environment });
        within(at("score-table"), `[data-task="${CSS.escape(environment)}"]`).focus();
      });
      const cell = element("th", { scope: "col", class: "number" }, button);
      if (sorted === environment) cell.setAttribute("aria-sort", "descending");
      return cell;
    });
    return element("tr", {}, element("th", { scope: "col" }, "Learner"), ...cells);
  }

  /**
   * The rows as submitted, or the best of the chosen task first, cells that lack runs after those.
   *
   * @param {Row[]} rows
   * @param {string[]} environments
   * @returns {Row[]}
   */
  #sorted(rows, environments) {
    const column = environments.indexOf(this.#view.get("sort"));
    if (column < 0) return rows;
    return rows.toSorted((a, b) => after(rank(a.entries[column]), rank(b.entries[column])));
  }
}

/**
 * Whether all its runs count, and its mean.
 *
 * @param {Standing | null} entry
 * @returns {[isWhole: number, mean: number]}
 */
function rank(entry) {
  if (entry === null) return [0, -Infinity];
  return [entry.n === entry.runs ? 1 : 0, entry.mean ?? -Infinity];
}

/**
 * What a sort takes: above 0 where the second is to come first.
 *
 * @param {[isWhole: number, mean: number]} first
 * @param {[isWhole: number, mean: number]} second
 * @returns {number}
 */
function after([isWhole, mean], [isOtherWhole, other]) {
  return isOtherWhole - isWhole || Number(other > mean) - Number(other < mean);
}

/**
 * @param {Row} row
 * @param {number} decimals
 * @param {Identities} known
 * @returns {HTMLElement}
 */
function bodyRow({ label, entries }, decimals, known) {
  const name = element("th", { scope: "row" }, swatch(identityOf(known, label)), label);
  return element("tr", {}, name, ...entries.map((entry) => valueCell(entry, decimals)));
}

/**
 * @param {Standing | null} entry
 * @param {number} decimals
 * @returns {HTMLElement}
 */
function valueCell(entry, decimals) {
  if (entry === null || entry.mean === null) {
    return element("td", { class: "number muted" }, entry === null ? "" : `– (${countText(entry)})`);
  }
  const fixed = (/** @type {number} */ value) => value.toFixed(decimals).replace("-", "−");
  const text = entry.std === null ? fixed(entry.mean) : `${fixed(entry.mean)} ± ${fixed(entry.std)}`;
  const note = element("small", { class: "muted" }, countText(entry));
  const value = element(entry.is_best ? "strong" : "span", {}, text);
  return element("td", { class: "number" }, value, note);
}

/**
 * "n 16", or "n 5 of 6, 1 diverged".
 *
 * @param {Pick<Standing, "n" | "runs" | "unfinished">} standing
 * @returns {string}
 */
function countText({ n, runs, unfinished }) {
  if (n === runs) return `n ${n}`;
  return [`n ${n} of ${runs}`, ...statusTexts(unfinished)].join(", ");
}
