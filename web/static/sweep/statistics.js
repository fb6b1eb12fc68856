/** What a sweep says of its learners over all tasks; asked for while it is open. */
import { ChartFigure } from "../charts/figure.js";
import { yScale } from "../charts/y_scale.js";
import { get, refusalOf } from "../connection/api.js";
import { at, element, setText, within } from "../parts/element.js";
import { identities, identityOf } from "../parts/identity.js";
import { swatch } from "../parts/swatch.js";
import { count, number, withBand } from "../texts/format.js";
import { statusTexts } from "../texts/sweep.js";
import { interval, scaleOf } from "./interval.js";
import { against, differenceMatrix, improvementMatrix, labelsOf } from "./pairs.js";

/**
 * @import { Entry, Identities } from "../parts/identity.js"
 * @import { Curve } from "../charts/layers.js"
 * @import { Field, View } from "../parts/view.js"
 * @import { Estimate } from "./interval.js"
 *
 * @typedef {object} Fields
 * @property {Field<boolean>} statistics
 * @property {Field<string>} reference   the label that pairs are compared with; "" for the usual
 * @property {Field<"final" | "return_history" | "area">} score
 */

const MOST_SENTENCES = 6; // more pairs are a matrix
const MATRIX_TEXT = "Bold: the interval excludes a tie; the title of each cell shows it.";

/** @type {import("../charts/limits.js").Limits} */
const NO_LIMITS = [null, null];

export class Statistics {
  #id;
  #view;
  #entries;
  /** @type {Api.Statistics | null} */
  #answer = null;
  /** @type {ChartFigure | null} */
  #profiles = null;

  /**
   * @param {() => string} id of the sweep, or of several that are joined
   * @param {View<Fields>} view
   * @param {() => Entry[]} entries those of them
   * @param {() => void} refetch asks for `load` to be called
   */
  constructor(id, view, entries, refetch) {
    this.#id = id;
    this.#view = view;
    this.#entries = entries;
    const details = at("statistics-details", HTMLDetailsElement);
    details.open = view.get("statistics");
    details.addEventListener("toggle", () => {
      if (details.open === view.get("statistics")) return;
      view.set({ statistics: details.open });
      refetch();
    });
    view.onChange((fields) => {
      if (fields.includes("score") || fields.includes("reference")) refetch();
    });
    document.addEventListener("themechange", () => this.#draw());
  }

  /** @param {AbortSignal} signal */
  async load(signal) {
    if (!this.#view.get("statistics")) return;
    try {
      const reference = this.#view.get("reference");
      const question = { score: this.#view.get("score"), reference };
      this.#answer = await get(`/sweeps/${this.#id()}/statistics`, question, signal);
    } catch (error) {
      setText(at("statistics-state"), refusalOf(error, 422).message);
      return;
    }
    this.#draw();
  }

  #draw() {
    const answer = this.#answer;
    if (answer?.sweep !== this.#id()) return;
    setText(at("statistics-state"), commonTasks(answer));
    const known = identities(this.#entries());
    const profiles = (this.#profiles ??= new ChartFigure(
      { title: "Performance profiles", label: "Performance profiles" },
      "profiles",
      { onToggle: () => {} },
    ));
    const body = at("statistics-body");
    const hadFocus = body.querySelector("[name=reference]:focus") !== null;
    body.replaceChildren(
      element(
        "div",
        {},
        meansSection(answer.interquartile_mean, known),
        this.#improvementSection(answer.probability_of_improvement, known),
      ),
      profiles.node,
      ...differencesSection(answer.paired_differences, known),
    );
    if (hadFocus) within(body, "[name=reference]").focus();
    const counts = new Map(answer.interquartile_mean.values.map(({ label, n }) => [label, n]));
    drawProfiles(profiles, answer.performance_profiles, known, counts);
  }

  /**
   * Pairs with the reference as intervals; all of them as a matrix where they are many.
   *
   * @param {Api.Statistics["probability_of_improvement"]} answer
   * @param {Identities} known
   * @returns {HTMLElement}
   */
  #improvementSection({ definition, pairs }, known) {
    const labels = labelsOf(pairs);
    const reference = this.#view.get("reference") || labels[0];
    const shown =
      pairs.length === 1 && !this.#view.get("reference")
        ? pairs.map(({ x, y, all_pairs: estimate }) => ({ x, y, estimate }))
        : against(pairs, reference);
    const scale = scaleOf([], [0, 1]);
    const rows = shown.map(({ x, y, estimate }) =>
      tableRow(
        [`P(${x} > ${y})`],
        estimateText(estimate),
        interval(estimate, identityOf(known, x).colour, scale, [0, 0.5, 1]),
      ),
    );
    const list = element("table", { class: "data intervals" }, element("tbody", {}, ...rows));
    const body = element("div", {}, list);
    if (pairs.length > MOST_SENTENCES) body.append(improvementMatrix(pairs, known));
    const text = pairs.length > MOST_SENTENCES ? `${MATRIX_TEXT} ${definition}` : definition;
    return framed("Probability of improvement", text, body, this.#referencePicker(labels));
  }

  /**
   * @param {string[]} labels
   * @returns {HTMLElement}
   */
  #referencePicker(labels) {
    const usual = element("option", { value: "" }, "the usual baseline");
    const options = labels.map((label) => element("option", { value: label }, label));
    const select = element("select", { name: "reference" }, usual, ...options);
    select.value = this.#view.get("reference");
    select.addEventListener("change", () => this.#view.set({ reference: select.value }));
    return element("label", {}, "compared with ", select);
  }
}

/**
 * @param {ChartFigure} figure
 * @param {Api.Statistics["performance_profiles"]} answer
 * @param {Identities} known
 * @param {Map<string, number>} counts of runs, by label
 */
function drawProfiles(figure, { definition, thresholds, profiles }, known, counts) {
  const x = /** @type {number[]} */ (thresholds); // of no gaps
  const curves = profiles.map(({ label, share, low, high }) => {
    const n = share.map(() => counts.get(label) ?? 0);
    return { ...identityOf(known, label), x, line: share, mean: share, low, high, n };
  });
  /** @type {import("../charts/chart.js").Data} */
  const data = {
    curves,
    references: [],
    x: { label: "normalised return", log: false, max: null, limits: NO_LIMITS },
    y: { label: "share of runs above", anchors: [0, 1], ...yScale([], false), limits: NO_LIMITS },
  };
  const isOpen = within(figure.node, "details", HTMLDetailsElement).open;
  const texts = { caption: definition, abscissa: "return" };
  figure.update(data, texts, { isOpen, fill: (table) => fillProfiles(table, curves) });
}

/**
 * @param {Api.Statistics} answer
 * @returns {string}
 */
function commonTasks({ definition, tasks, lacking, unscored, incomplete }) {
  if (tasks.length === 0) return "No task has a score of every learner yet: runs count when they have ended.";
  const rest = lacking.map(({ environment }) => environment);
  const left = rest.length > 0 ? ` Left out, because a learner has no score there: ${rest.join(", ")}.` : "";
  const without = unscored.length > 0 ? ` Without any score: ${unscored.join(", ")}.` : "";
  return `Over ${tasks.join(", ")}. ${definition}${left}${without}${missing(incomplete)}`;
}

/**
 * Which cells lack runs, and what that does to their scores.
 *
 * @param {Api.Statistics["incomplete"]} incomplete
 * @returns {string}
 */
function missing(incomplete) {
  if (incomplete.length === 0) return "";
  const cells = incomplete.map(({ label, environment, n, runs, unfinished }) => {
    return `${label} in ${environment}: ${[`n ${n} of ${runs}`, ...statusTexts(unfinished)].join(", ")}`;
  });
  return ` ${cells.join("; ")}. Where runs failed or diverged, the scores are likely to be too high.`;
}

/**
 * @param {Api.Statistics["interquartile_mean"]} answer
 * @param {Identities} known
 * @returns {HTMLElement}
 */
function meansSection({ definition, values }, known) {
  const scale = scaleOf(values, [0, 1]);
  const rows = values.map((each) => {
    const identity = identityOf(known, each.label);
    return tableRow(
      [swatch(identity), each.label],
      `${estimateText(each)}, n ${count(each.n)}`,
      interval(each, identity.colour, scale, [0, 1]),
    );
  });
  return section("Interquartile mean", definition, rows);
}

/**
 * @param {Api.Statistics["paired_differences"]} answer
 * @param {Identities} known
 * @returns {HTMLElement[]}
 */
function differencesSection({ definition, values }, known) {
  if (values.length === 0) return [];
  const title = "Paired differences in area";
  if (values.length > MOST_SENTENCES) {
    const text = `${MATRIX_TEXT} ${definition}`;
    return [framed(title, text, differenceMatrix(values, known))];
  }
  const shown = values.flatMap(({ mean: value, ...rest }) => (value === null ? [] : { ...rest, value }));
  const scale = scaleOf(shown, [0]);
  const rows = shown.map((each) => {
    const { environment, label, baseline, pairs, n, wins, value, low, high } = each;
    return tableRow(
      [`${environment}: ${label} − ${baseline}`],
      `${withBand(value, low, high)}, ${wins} of ${n} pairs won${n < pairs ? `, of ${pairs}` : ""}`,
      interval(each, "currentColor", scale, [0]),
    );
  });
  return [section(title, definition, rows)];
}

/**
 * @param {string} title
 * @param {string} definition
 * @param {HTMLElement[]} rows
 * @returns {HTMLElement}
 */
function section(title, definition, rows) {
  const body = element("table", { class: "data intervals" }, element("tbody", {}, ...rows));
  return framed(title, definition, body);
}

/**
 * @param {string} title
 * @param {string} definition
 * @param {HTMLElement} body
 * @param {HTMLElement} [choice] what stands beside the title
 * @returns {HTMLElement}
 */
function framed(title, definition, body, choice = undefined) {
  const scroller = element("div", { "class": "scroller", "role": "region", "tabindex": "0" }, body);
  scroller.setAttribute("aria-label", title);
  return element(
    "section",
    {},
    element("div", { class: "section-head" }, element("h3", {}, title), choice),
    scroller,
    element("p", { class: "definition" }, definition),
  );
}

/**
 * @param {(Node | string)[]} name
 * @param {string} text
 * @param {Element} picture
 * @returns {HTMLElement}
 */
function tableRow(name, text, picture) {
  return element(
    "tr",
    {},
    element("th", { scope: "row" }, ...name),
    element("td", { class: "number" }, text),
    element("td", {}, picture),
  );
}

/**
 * @param {Estimate} estimate
 * @returns {string}
 */
function estimateText({ value, low, high }) {
  if (low === null || high === null) return number(value);
  return `${value.toFixed(3)} [${low.toFixed(3)}, ${high.toFixed(3)}]`.replaceAll("-", "−");
}

/**
 * @param {HTMLTableElement} table
 * @param {Curve[]} curves
 */
function fillProfiles(table, curves) {
  const columns = curves.map(({ label }) => element("th", { scope: "col" }, label));
  const rows = curves[0].x.map((threshold, i) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, number(threshold)),
      ...curves.map(({ line }) => element("td", {}, number(line[i]))),
    ),
  );
  const head = element("tr", {}, element("th", { scope: "col" }, "above"), ...columns);
  table.replaceChildren(element("thead", {}, head), element("tbody", {}, ...rows));
}
