/** What a sweep's search has found: a sentence a task, and its entries' scores rung by rung. */
import { get } from "../connection/api.js";
import { at, element, keyed, setText } from "../parts/element.js";
import { identities, identityOf } from "../parts/identity.js";
import { swatch } from "../parts/swatch.js";
import { count, counted } from "../texts/format.js";

/** @import { Identities } from "../parts/identity.js" */
/** @typedef {{ task: Api.SearchedTask, known: Identities }} Shown */
/** @typedef {Api.SearchedTask["rungs"][number]} Rung */

export class Search {
  #id;
  #entries;
  /** @type {Api.Search | null} */
  #answer = null;
  #show = keyed(
    at("search-tasks"),
    (/** @type {Shown} */ { task: { environment } }) => environment,
    () => new SearchedTask(),
  );

  /**
   * @param {string} id
   * @param {() => Api.Entry[]} entries those of the sweep
   */
  constructor(id, entries) {
    this.#id = id;
    this.#entries = entries;
    document.addEventListener("themechange", () => this.#draw());
  }

  /**
   * Only a sweep that searches has one.
   *
   * @param {AbortSignal} signal
   */
  async load(signal) {
    this.#answer = await get(`/sweeps/${this.#id}/search`, {}, signal);
    at("search").hidden = false;
    this.#draw();
  }

  #draw() {
    if (this.#answer === null) return;
    const { tasks, budget, timesteps, seeds, score, kept_apart: apart, definition } = this.#answer;
    const known = identities(this.#entries());
    this.#show(tasks.map((task) => ({ task, known })));
    const size = `${count(timesteps)} of ${count(budget)} timesteps, ${counted(seeds.length, "seed")}`;
    setText(at("search-summary"), `The best entry of each task by ${score}: ${size}.`);
    setText(at("search-apart"), apart);
    setText(at("search-definition"), definition.replaceAll("`", ""));
  }
}

class SearchedTask {
  #title = element("h3");
  #sentence = element("p");
  #table = element("table", { class: "data" });
  #scroller = element("div", { class: "scroller", role: "region", tabindex: "0" }, this.#table);
  node = element("li", {}, this.#title, this.#sentence, this.#scroller);

  /** @param {Shown} shown */
  update({ task: { environment, sentence, winner, rungs }, known }) {
    setText(this.#title, environment);
    this.#sentence.className = winner === null ? "" : "won";
    setText(this.#sentence, sentence.replaceAll(/-(?=\d)/g, "−"));
    this.#scroller.setAttribute("aria-label", `Rungs in ${environment}`);
    const heads = rungs.map(({ timesteps }) => `at ${count(timesteps)}`);
    this.#table.replaceChildren(
      element("thead", {}, element("tr", {}, heading("Entry"), ...heads.map((each) => heading(each, "number")))),
      element("tbody", {}, ...labels(rungs).map((label) => row(label, rungs, known))),
    );
  }
}

/**
 * @param {string} text
 * @param {string} [kind]
 * @returns {HTMLElement}
 */
function heading(text, kind) {
  return element("th", { scope: "col", class: kind }, text);
}

/**
 * The entries, those that came farthest first, and of them the best.
 *
 * @param {Rung[]} rungs
 * @returns {string[]}
 */
function labels(rungs) {
  const farthest = rungs.toReversed().flatMap(({ standings }) => standings.map(({ label }) => label));
  return [...new Set(farthest)];
}

/**
 * @param {string} label
 * @param {Rung[]} rungs
 * @param {Identities} known
 * @returns {HTMLElement}
 */
function row(label, rungs, known) {
  const cells = rungs.map(({ standings }) => cell(standings.find((each) => each.label === label)));
  const name = element("th", { scope: "row" }, swatch(identityOf(known, label)), label);
  return element("tr", {}, name, ...cells);
}

/**
 * @param {Rung["standings"][number] | undefined} standing undefined: not on this rung
 * @returns {HTMLElement}
 */
function cell(standing) {
  if (standing === undefined) return element("td", { class: "number muted" }, "–");
  const text = standingText(standing);
  return element("td", { class: "number" }, standing.goes_on ? element("strong", {}, text) : text);
}

/**
 * @param {Rung["standings"][number]} standing
 * @returns {string}
 */
function standingText({ score, climbing, diverged, failed }) {
  if (climbing > 0) return `${climbing} on the way`;
  if (failed > 0) return `left out: ${counted(failed, "run")} failed or cancelled`;
  const text = score === null ? "–" : score.toFixed(3).replace("-", "−");
  return diverged > 0 ? `${text} (${diverged} diverged)` : text;
}
