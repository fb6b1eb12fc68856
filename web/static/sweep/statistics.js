/** What a sweep says of its learners over all tasks; asked for while it is open. */
import { ChartFigure } from "../charts/figure.js";
import { get } from "../connection/api.js";
import { element, setText } from "../parts/element.js";
import { identities } from "../parts/identity.js";
import { swatch } from "../parts/swatch.js";
import { count, number, withBand } from "../texts/format.js";
import { statusTexts } from "../texts/sweep.js";
import { interval, scaleOf } from "./interval.js";

const at = (name) => document.getElementById(name);

export class Statistics {
  #id;
  #view;
  #entries;
  #answer = null;
  #profiles = null;

  /**
   * @param entries () => those of the sweep, as identity.js takes them
   * @param refetch () => void; asks for `load` to be called
   */
  constructor(id, view, entries, refetch) {
    this.#id = id;
    this.#view = view;
    this.#entries = entries;
    const details = at("statistics-details");
    details.open = view.get("statistics");
    details.addEventListener("toggle", () => {
      if (details.open === view.get("statistics")) return;
      view.set({ statistics: details.open });
      refetch();
    });
    view.addEventListener("change", ({ detail: fields }) => fields.includes("score") && refetch());
    document.addEventListener("themechange", () => this.#draw());
  }

  async load(signal) {
    if (!this.#view.get("statistics")) return;
    try {
      this.#answer = await get(`/sweeps/${this.#id}/statistics`, { score: this.#view.get("score") }, signal);
    } catch (error) {
      if (error.status !== 422) throw error;
      setText(at("statistics-state"), error.message);
      return;
    }
    this.#draw();
  }

  #draw() {
    if (this.#answer === null) return;
    const answer = this.#answer;
    setText(at("statistics-state"), commonTasks(answer));
    const known = identities(this.#entries());
    this.#profiles ??= new ChartFigure(
      { title: "Performance profiles", label: "Performance profiles" },
      "profiles",
      () => {},
    );
    at("statistics-body").replaceChildren(
      element(
        "div",
        {},
        meansSection(answer.interquartile_mean, known),
        improvementSection(answer.probability_of_improvement, known),
      ),
      this.#profiles.node,
      ...differencesSection(answer.paired_differences),
    );
    const counts = new Map(answer.interquartile_mean.values.map(({ label, n }) => [label, n]));
    this.#drawProfiles(answer.performance_profiles, known, counts);
  }

  #drawProfiles({ definition, thresholds, profiles }, known, counts) {
    const curves = profiles.map(({ label, share, low, high }) => {
      const { colour, dash } = known.get(label);
      const n = share.map(() => counts.get(label));
      return { label, colour, dash, x: thresholds, line: share, mean: share, low, high, n };
    });
    const data = {
      curves,
      references: [],
      x: { label: "normalised return", log: false, max: null },
      y: { label: "share of runs above", scale: "linear", linearWithin: 1, anchors: [0, 1] },
    };
    const texts = { caption: definition, abscissa: "return" };
    const isOpen = this.#profiles.node.querySelector("details").open;
    this.#profiles.update(data, texts, { isOpen, fill: (table) => fillProfiles(table, curves) });
  }
}

function commonTasks({ definition, tasks, lacking, unscored, incomplete }) {
  if (tasks.length === 0) return "No task has a score of every learner yet: runs count at their end.";
  const rest = lacking.map(({ environment }) => environment);
  const left = rest.length > 0 ? ` Left out, because a learner has no score there: ${rest.join(", ")}.` : "";
  const without = unscored.length > 0 ? ` Without any score: ${unscored.join(", ")}.` : "";
  return `Over ${tasks.join(", ")}. ${definition}${left}${without}${missing(incomplete)}`;
}

/** Which cells lack runs, and what that does to their scores. */
function missing(incomplete) {
  if (incomplete.length === 0) return "";
  const cells = incomplete.map(({ label, environment, n, runs, unfinished }) => {
    return `${label} in ${environment}: ${[`n ${n} of ${runs}`, ...statusTexts(unfinished)].join(", ")}`;
  });
  return ` ${cells.join("; ")}. Where runs failed or diverged, the others say too much.`;
}

function meansSection({ definition, values }, known) {
  const scale = scaleOf(values, [0, 1]);
  const rows = values.map((each) => {
    const identity = known.get(each.label);
    return tableRow(
      [swatch(identity), each.label],
      `${estimateText(each)}, n ${count(each.n)}`,
      interval(each, identity.colour, scale, [0, 1]),
    );
  });
  return section("Interquartile mean", definition, rows);
}

function improvementSection({ definition, pairs }, known) {
  const scale = () => scaleOf([], [0, 1]);
  const rows = pairs.map(({ x, y, all_pairs: estimate }) =>
    tableRow(
      [`P(${x} > ${y})`],
      estimateText(estimate),
      interval(estimate, known.get(x).colour, scale(), [0, 0.5, 1]),
    ),
  );
  return section("Probability of improvement", definition, rows);
}

function differencesSection({ definition, values }) {
  if (values.length === 0) return [];
  const shown = values.filter(({ mean }) => mean !== null);
  const scale = scaleOf(
    shown.map(({ mean, low, high }) => ({ value: mean, low, high })),
    [0],
  );
  const rows = shown.map(({ environment, label, baseline, pairs, n, wins, mean, low, high }) =>
    tableRow(
      [`${environment}: ${label} − ${baseline}`],
      `${withBand(mean, low, high)}, ${wins} of ${n} pairs won${n < pairs ? `, of ${pairs}` : ""}`,
      interval({ value: mean, low, high }, "currentColor", scale, [0]),
    ),
  );
  return [section("Paired differences in area", definition, rows)];
}

function section(title, definition, rows) {
  const body = element("table", { class: "data intervals" }, element("tbody", {}, ...rows));
  const scroller = element("div", { "class": "scroller", "role": "region", "tabindex": "0" }, body);
  scroller.setAttribute("aria-label", title);
  return element(
    "section",
    {},
    element("h3", {}, title),
    scroller,
    element("p", { class: "definition" }, definition),
  );
}

function tableRow(name, text, picture) {
  return element(
    "tr",
    {},
    element("th", { scope: "row" }, ...name),
    element("td", { class: "number" }, text),
    element("td", {}, picture),
  );
}

function estimateText({ value, low, high }) {
  if (low === null || high === null) return number(value);
  return `${value.toFixed(3)} [${low.toFixed(3)}, ${high.toFixed(3)}]`.replaceAll("-", "−");
}

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
