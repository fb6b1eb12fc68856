/** Two or more sweeps or runs: their curves on one axis, their settings side by side. */
import { saveText, toCsv } from "../curves/curve_table.js";
import { MetricChoice } from "../curves/metric_choice.js";
import { comparisonOf, question } from "../curves/question.js";
import { CurvesSection } from "../curves/section.js";
import { get, refusalOf } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Refresh } from "../connection/refresh.js";
import { offerSharing } from "../connection/sharing.js";
import * as connection from "../connection/state.js";
import { isGuest } from "../parts/caller.js";
import { Controls } from "../parts/controls.js";
import { at, element, keyed, setText } from "../parts/element.js";
import { COMPARISON_FIELDS, flag, list, oneOf, text, View } from "../parts/view.js";
import { comparedRun, comparedSweep, isSweep, overlaid, overlaidEntries } from "../compare/compared.js";
import { fillDifferences } from "../compare/differences.js";
import { FigureBuilder } from "../sweep/figure_builder.js";
import { FIGURE_FIELDS } from "../sweep/figure_query.js";
import { ScoreTable } from "../sweep/scores.js";
import { Statistics } from "../sweep/statistics.js";

const OFFERED = 200;

const view = new View({
  ...COMPARISON_FIELDS,
  ...FIGURE_FIELDS,
  sweep: list, // ids
  run: list, // ids
  score: oneOf("final", "return_history", "area"),
  sort: text, // the environment by which the score table is sorted
  statistics: flag, // whether they are open
  reference: text, // the label that pairs are compared with there
  same: flag, // whether settings that agree are shown
});
/** @import { Compared } from "../compare/compared.js" */

const same = at("same", HTMLInputElement);
const offered = at("add", HTMLSelectElement);
const curves = new CurvesSection(view);
const showChosen = keyed(at("chosen"), ({ id }) => id, chip);
/** @type {Compared[]} */
let compared = [];

if (view.get("run").length > 0) view.set({ band: "none" }); // a single run has none
new Controls(at("controls", HTMLFormElement), view);
new Controls(at("score-controls", HTMLFormElement), view);
const metrics = new MetricChoice(at("controls", HTMLFormElement), view);
const together = () => compared.filter(isSweep).map(({ id }) => id).join("+"); // answered as one
const builder = new FigureBuilder(together, view);
const onError = (/** @type {Error} */ error) => connection.failed(error);
const refresh = new Refresh(load, { interval: 2000, onError });
const refreshScores = new Refresh(loadScores, { interval: 3000, onError });
const refreshStatistics = new Refresh(loadStatistics, { interval: 10_000, onError });
const scores = new ScoreTable(together, view, answeredEntries, () => refreshScores.hurry(), () => {});
const statistics = new Statistics(together, view, answeredEntries, () => refreshStatistics.hurry());

at("scores").hidden = at("statistics").hidden = true;
follow("", (kind) => {
  if (kind !== "run") refresh.request();
});
if (!isGuest) offerSweeps();
offerSharing(sweepsShown);
view.onChange((fields) => {
  const asked = ["metric", "scale", "x", "band", "seeds", "sweep", "run"];
  if (fields.some((field) => asked.includes(field))) refresh.hurry();
  else draw();
});
document.addEventListener("themechange", draw);
at("download-csv").addEventListener("click", () => {
  saveText(toCsv({ ...comparisonOf(view), panels: overlaid(compared) }), "comparison.csv");
});
same.checked = view.get("same");
same.addEventListener("change", () => view.set({ same: same.checked }));
offered.addEventListener("change", () => {
  view.set({ sweep: [...new Set([...view.get("sweep"), offered.value])] });
  offered.value = "";
});

/** @param {AbortSignal} signal */
async function load(signal) {
  const asked = [
    ...view.get("sweep").map((id) => comparedSweep(id, question(view), signal)),
    ...view.get("run").map((id) => comparedRun(id, question(view), signal)),
  ];
  try {
    compared = await Promise.all(asked);
  } catch (error) {
    setText(at("missing"), refusalOf(error, 404, 422).message);
    at("missing").hidden = false;
    return;
  }
  at("missing").hidden = true;
  draw();
  connection.fresh();
  const hasSweeps = together() !== "";
  at("scores").hidden = at("statistics").hidden = !hasSweeps;
  if (!hasSweeps) return;
  metrics.offer(await get(`/sweeps/${together()}/metrics`, {}, signal));
  refreshScores.request();
  refreshStatistics.request();
}

/** @param {AbortSignal} signal */
async function loadScores(signal) {
  if (together() !== "") await orSayWhy(() => scores.load(signal));
}

/** @param {AbortSignal} signal */
async function loadStatistics(signal) {
  if (together() !== "") await orSayWhy(() => statistics.load(signal));
}

/**
 * Say why sweeps cannot be compared, such as a task that changed between them.
 *
 * @param {() => Promise<void>} load
 */
async function orSayWhy(load) {
  try {
    await load();
  } catch (error) {
    setText(at("missing"), refusalOf(error, 409).message);
    at("missing").hidden = false;
    at("scores").hidden = at("statistics").hidden = true;
  }
}

/** The entries under the names that the service answers with: those of several sweeps say whose. */
function answeredEntries() {
  const sweeps = compared.filter(isSweep);
  if (sweeps.length > 1) return overlaidEntries(compared);
  return [...sweeps.flatMap(({ entries }) => entries), ...overlaidEntries(compared)];
}

function draw() {
  const isEmpty = compared.length === 0;
  at("curves").hidden = at("settings").hidden = isEmpty;
  showChosen(compared);
  if (isEmpty) return;
  curves.draw(overlaid(compared), overlaidEntries(compared), null);
  drawDownloads(compared.filter(isSweep));
  const table = at("differences", HTMLTableElement);
  const differing = fillDifferences(table, compared, view.get("same"));
  at("alike").hidden = differing > 0 || compared.length < 2;
}

/**
 * What the service draws and reports, which is of sweeps: runs are on the screen alone.
 *
 * @param {Compared[]} sweeps
 */
function drawDownloads(sweeps) {
  const hasSweeps = sweeps.length > 0;
  at("downloads-shown").hidden = at("downloads-all").hidden = at("figure-builder").hidden = !hasSweeps;
  if (!hasSweeps) return;
  const panels = sweeps.length > 1 ? overlaid(sweeps) : sweeps[0].panels;
  builder.update(panels, answeredEntries(), null);
}

/**
 * @param {Compared} compared
 * @returns {{ node: HTMLElement, update: () => void }}
 */
function chip({ id, name, page }) {
  const drop = element("button", { type: "button", class: "quiet" }, "Remove");
  drop.setAttribute("aria-label", `Remove ${name}`);
  drop.addEventListener("click", () => {
    const without = (/** @type {string[]} */ ids) => ids.filter((each) => each !== id);
    view.set({ sweep: without(view.get("sweep")), run: without(view.get("run")) });
  });
  return { node: element("li", {}, element("a", { href: page }, name), drop), update: () => {} };
}

/** @returns {string[]} the sweeps that are compared, and those that have the runs */
function sweepsShown() {
  const ofRuns = view.get("run").map((id) => id.split("-")[0]);
  return [...new Set([...view.get("sweep"), ...ofRuns])];
}

async function offerSweeps() {
  try {
    const { items } = await get("/sweeps", { limit: OFFERED });
    offered.append(
      ...items.map((sweep) => element("option", { value: sweep.id }, `${sweep.name} (${sweep.id})`)),
    );
  } catch (error) {
    connection.refused(refusalOf(error));
  }
}
