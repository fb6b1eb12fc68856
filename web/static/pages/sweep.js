/** A sweep's page: its state, its curves as they grow, its scores. */
import { saveText, toCsv } from "../curves/curve_table.js";
import { MetricChoice } from "../curves/metric_choice.js";
import { question } from "../curves/question.js";
import { CurvesSection } from "../curves/section.js";
import { get } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Refresh } from "../connection/refresh.js";
import { offerSharing } from "../connection/sharing.js";
import * as connection from "../connection/state.js";
import { DiagnosisSection } from "../diagnosis/section.js";
import { Controls } from "../parts/controls.js";
import { at, setText } from "../parts/element.js";
import { COMPARISON_FIELDS, flag, oneOf, text, View } from "../parts/view.js";
import { DoneNotice } from "../sweep/done_notice.js";
import { Search } from "../question/search.js";
import { Verdict } from "../question/verdict.js";
import { FigureBuilder } from "../sweep/figure_builder.js";
import { FIGURE_FIELDS } from "../sweep/figure_query.js";
import { SweepHead } from "../sweep/head.js";
import { PaperFigures } from "../sweep/paper_figures.js";
import { Growth } from "../submit/growth.js";
import { ScoreTable } from "../sweep/scores.js";
import { MAP_FIELDS, SettingsMaps } from "../sweep/settings_maps.js";
import { Statistics } from "../sweep/statistics.js";

const id = at("sweep").dataset.sweep ?? "";

const view = new View({
  ...COMPARISON_FIELDS,
  ...FIGURE_FIELDS,
  ...MAP_FIELDS,
  score: oneOf("final", "return_history", "area"),
  sort: text, // the environment by which the score table is sorted
  figures: flag, // whether the paper's are open
  statistics: flag, // whether they are open
  reference: text, // the label that pairs are compared with there
});
new Controls(at("controls", HTMLFormElement), view);
new Controls(at("score-controls", HTMLFormElement), view);
const metrics = new MetricChoice(at("controls", HTMLFormElement), view);
const curves = new CurvesSection(view);
const builder = new FigureBuilder(() => id, view);

/** @type {Api.Curves | null} */
let comparison = null; // the latest curves, and the question that they answer
let answered = "";

const onError = (/** @type {Error} */ error) => connection.failed(error);
const refreshSweep = new Refresh(loadSweep, { interval: 1000, onError });
const refreshCurves = new Refresh(loadCurves, { interval: 500, onError });
const refreshMetrics = new Refresh(loadMetrics, { interval: 6000, onError });
const refreshScores = new Refresh((signal) => scores.load(signal), { interval: 3000, onError });
const refreshStatistics = new Refresh((signal) => statistics.load(signal), {
  interval: 10_000,
  onError,
});
const head = new SweepHead(id, "", () => refreshSweep.hurry(), hideAll);
const growth = new Growth(id, () => refreshSweep.hurry());
const figures = new PaperFigures(view);
const notice = new DoneNotice(id);
const entries = () => head.sweep?.entries ?? [];
const maps = new SettingsMaps(view, entries);
const scores = new ScoreTable(
  () => id,
  view,
  entries,
  () => refreshScores.hurry(),
  (answer) => maps.show(answer),
);
const statistics = new Statistics(() => id, view, entries, () => refreshStatistics.hurry());
const verdict = new Verdict(id, entries);
const refreshVerdict = new Refresh((signal) => verdict.load(signal), { interval: 5000, onError });
const search = new Search(id, entries);
const refreshSearch = new Refresh((signal) => search.load(signal), { interval: 5000, onError });
const diagnosis = new DiagnosisSection(`/sweeps/${id}`, () => refreshDiagnosis.hurry());
const refreshDiagnosis = new Refresh((signal) => diagnosis.load(signal), {
  interval: 2000,
  onError,
});

const stream = follow(id, (kind) => {
  if (kind !== "measurements") requestDiagnosis();
  if (kind === "diagnosis") return;
  refreshSweep.request();
  requestFindings();
  notice.changed();
  if (kind === "run") return;
  refreshCurves.request();
  requestRest();
});

view.onChange(() => {
  if (JSON.stringify(question(view)) !== answered) refreshCurves.hurry();
  else draw();
});
document.addEventListener("themechange", draw);
offerSharing(() => [id]);
at("download-csv").addEventListener("click", downloadCsv);
at("copy-link").addEventListener("click", copyLink);

/** @param {AbortSignal} signal */
async function loadSweep(signal) {
  const isFirst = head.sweep === null;
  await head.load(signal);
  if (head.sweep !== null) {
    notice.offer(head.sweep);
    growth.show(head.sweep);
  }
  if (!isFirst || head.sweep === null) return;
  // Entries of a search differ in length, and the best was chosen: nothing follows from a test.
  at("statistics").hidden = Boolean(head.sweep.request.search);
  draw();
  requestFindings();
  requestRest();
  figures.show(head.sweep.links);
}

/** What the sweep is asked, or searches, if it does. */
function requestFindings() {
  if (head.sweep?.request.question) refreshVerdict.request();
  if (head.sweep?.request.search) refreshSearch.request();
}

/** What lies below the curves, and waits for them: the service would answer all at once, slower. */
function requestRest() {
  if (head.sweep === null || comparison === null) return;
  refreshMetrics.request();
  refreshScores.request();
  if (!at("statistics").hidden) refreshStatistics.request();
}

/** It waits for the curves too, and changes with runs that end, not with what they measure. */
function requestDiagnosis() {
  if (comparison !== null) refreshDiagnosis.request();
}

/** @param {AbortSignal} signal */
async function loadCurves(signal) {
  const asked = question(view);
  const isFirst = comparison === null;
  at("curves").setAttribute("aria-busy", "true");
  comparison = await get(`/sweeps/${id}/curves`, asked, signal);
  answered = JSON.stringify(asked);
  at("curves").removeAttribute("aria-busy");
  at("loading").hidden = true;
  draw();
  connection.fresh();
  if (!isFirst) return;
  requestRest();
  requestDiagnosis();
}

/**
 * What there is to show: learners differ in their diagnostics, and start one after the other.
 *
 * @param {AbortSignal} signal
 */
async function loadMetrics(signal) {
  metrics.offer(await get(`/sweeps/${id}/metrics`, {}, signal));
}

/** Draw the latest answer, unless the person already asks for another. */
function draw() {
  if (head.sweep === null || comparison === null) return;
  if (JSON.stringify(question(view)) !== answered) return;
  const xMax = comparison.x === "timesteps" ? timestepsOf(head.sweep.request) : null;
  curves.draw(comparison.panels, entries(), xMax);
  builder.update(comparison.panels, entries(), xMax);
  setText(at("definition"), comparison.definition);
}

/**
 * The timesteps of every run, null where presets say them or a share is taken.
 *
 * @param {Api.Request} request
 * @returns {number | null}
 */
function timestepsOf({ timesteps, scale = 1 }) {
  return scale === 1 ? (timesteps ?? null) : null;
}

function downloadCsv() {
  if (comparison === null) return;
  saveText(toCsv(comparison), `sweep-${id}-${comparison.metric}.csv`);
}

async function copyLink() {
  await navigator.clipboard.writeText(location.href);
  setText(at("copy-link"), "Copied");
  setTimeout(() => setText(at("copy-link"), "Copy link"), 2000);
}

function hideAll() {
  stream.close();
  at("curves").hidden = at("scores").hidden = at("statistics").hidden = true;
  at("verdict").hidden = at("search").hidden = at("diagnosis").hidden = at("settings-maps").hidden = true;
}
