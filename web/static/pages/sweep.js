/** A sweep's page: its state, its curves as they grow, its scores. */
import { toCsv } from "../charts/curve_table.js";
import { Legend } from "../charts/legend.js";
import { MetricChoice } from "../charts/metric_choice.js";
import { Panel } from "../charts/panel.js";
import { question } from "../charts/question.js";
import { address, get } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Refresh } from "../connection/refresh.js";
import * as connection from "../connection/state.js";
import { DiagnosisSection } from "../diagnosis/section.js";
import { Controls } from "../parts/controls.js";
import { at, keyed, setText } from "../parts/element.js";
import { identities } from "../parts/identity.js";
import { CURVE_FIELDS, flag, list, name, oneOf, text, View, xLabel } from "../parts/view.js";
import { SweepHead } from "../sweep/head.js";
import { PaperFigures } from "../sweep/paper_figures.js";
import { ScoreTable } from "../sweep/scores.js";
import { Statistics } from "../sweep/statistics.js";

/** @import { Shown } from "../charts/panel.js" */

const id = at("sweep").dataset.sweep ?? "";

const view = new View({
  ...CURVE_FIELDS,
  metric: name("return_mean"),
  scale: oneOf("normalized", "raw"),
  band: oneOf("std", "ci95", "iqr", "none"),
  seeds: flag,
  hide: list, // labels of curves
  score: oneOf("final", "return_history", "area"),
  sort: text, // the environment by which the score table is sorted
  figures: flag, // whether the paper's are open
  statistics: flag, // whether they are open
});
new Controls(at("controls", HTMLFormElement), view);
new Controls(at("score-controls", HTMLFormElement), view);
const metrics = new MetricChoice(at("controls", HTMLFormElement), view);
const legend = new Legend(at("legend"), view);
const showPanels = keyed(
  at("panels"),
  (/** @type {Shown} */ { panel }) => panel.environment,
  ({ panel }) => new Panel(panel.environment, view),
);

/** @type {Api.Curves | null} */
let comparison = null; // the latest curves, and the question that they answer
let answered = "";

const onError = (/** @type {Error} */ error) => connection.failed(error);
const refreshSweep = new Refresh(loadSweep, { interval: 1000, onError });
const refreshCurves = new Refresh(loadCurves, { interval: 500, onError });
const refreshMetrics = new Refresh(loadMetrics, { interval: 30_000, onError });
const refreshScores = new Refresh((signal) => scores.load(signal), { interval: 3000, onError });
const refreshStatistics = new Refresh((signal) => statistics.load(signal), {
  interval: 10_000,
  onError,
});
const head = new SweepHead(id, "", () => refreshSweep.hurry(), hideAll);
const figures = new PaperFigures(view);
const entries = () => head.sweep?.entries ?? [];
const scores = new ScoreTable(id, view, entries, () => refreshScores.hurry());
const statistics = new Statistics(id, view, entries, () => refreshStatistics.hurry());
const diagnosis = new DiagnosisSection(`/sweeps/${id}`, () => refreshDiagnosis.hurry());
const refreshDiagnosis = new Refresh((signal) => diagnosis.load(signal), {
  interval: 2000,
  onError,
});

const stream = follow(address(`/sweeps/${id}/events`), (kind) => {
  if (kind !== "measurements") requestDiagnosis();
  if (kind === "diagnosis") return;
  refreshSweep.request();
  if (kind === "run") return;
  refreshCurves.request();
  requestRest();
});

view.onChange(() => {
  showDownloads();
  if (JSON.stringify(question(view)) !== answered) refreshCurves.hurry();
  else draw();
});
document.addEventListener("themechange", draw);
at("download-csv").addEventListener("click", downloadCsv);
at("copy-link").addEventListener("click", copyLink);
showDownloads();

/** @param {AbortSignal} signal */
async function loadSweep(signal) {
  const isFirst = head.sweep === null;
  await head.load(signal);
  if (!isFirst || head.sweep === null) return;
  draw();
  requestRest();
  figures.show(head.sweep.links);
}

/** What lies below the curves, and waits for them: the service would answer all at once, slower. */
function requestRest() {
  if (head.sweep === null || comparison === null) return;
  refreshMetrics.request();
  refreshScores.request();
  refreshStatistics.request();
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
  const known = identities(entries());
  const axes = {
    xLabel: xLabel(comparison.x),
    yLabel: comparison.normalized ? `normalised ${comparison.metric}` : comparison.metric,
    xMax: comparison.x === "timesteps" ? timestepsOf(head.sweep.request) : null,
  };
  legend.update(known, comparison.panels);
  showPanels(comparison.panels.map((panel) => ({ panel, known, axes })));
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

function showDownloads() {
  const { normalized, band, x } = question(view);
  for (const form of ["png", "svg", "pdf"]) {
    const link = at(`download-${form}`, HTMLAnchorElement);
    link.href = address(`/sweeps/${id}/plot.${form}`, { normalized, band, x });
    link.download = `sweep-${id}.${form}`;
  }
}

function downloadCsv() {
  if (comparison === null) return;
  const blob = new Blob([toCsv(comparison)], { type: "text/csv" });
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `sweep-${id}-${comparison.metric}.csv`;
  link.click();
  URL.revokeObjectURL(link.href);
}

async function copyLink() {
  await navigator.clipboard.writeText(location.href);
  setText(at("copy-link"), "Copied");
  setTimeout(() => setText(at("copy-link"), "Copy link"), 2000);
}

function hideAll() {
  stream.close();
  at("curves").hidden = at("scores").hidden = at("statistics").hidden = true;
  at("diagnosis").hidden = true;
}
