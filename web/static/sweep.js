/** A sweep's page: its state, its curves as they grow, its runs. */
import { address, get } from "./api.js";
import * as connection from "./connection.js";
import { Controls } from "./controls.js";
import { toCsv } from "./curve_table.js";
import { RETURNS } from "./drawing.js";
import { keyed, setText } from "./element.js";
import { percent, remaining } from "./format.js";
import { identities } from "./identity.js";
import { Legend } from "./legend.js";
import { follow } from "./live.js";
import { Panel } from "./panel.js";
import { Refresh } from "./refresh.js";
import { Runs } from "./runs.js";
import { cancelSweep, isActive, statusCounts, summary, timeElement } from "./sweep_text.js";
import { View } from "./view.js";

const MAX_POINTS = 300;
const id = document.getElementById("sweep").dataset.sweep;
const at = (name) => document.getElementById(name);

const view = new View();
const controls = new Controls(at("controls"), view);
const legend = new Legend(at("legend"), view);
const showCounts = statusCounts(at("counts"));
const showPanels = keyed(
  at("panels"),
  ({ panel }) => panel.environment,
  ({ panel }) => new Panel(panel.environment, view),
);

let sweep = null;
let comparison = null; // the latest curves, and the question that they answer
let answered = "";

const onError = (error) => connection.failed(error);
const refreshSweep = new Refresh(loadSweep, { interval: 1000, onError });
const refreshCurves = new Refresh(loadCurves, { interval: 500, onError });
const refreshMetrics = new Refresh(loadMetrics, { interval: 30_000, onError });
const refreshRuns = new Refresh((signal) => runs.load(signal), { interval: 2000, onError });
const runs = new Runs(id, view, () => refreshRuns.hurry());

const stream = follow(address(`/sweeps/${id}/events`), (kind) => {
  refreshSweep.request();
  refreshRuns.request();
  if (kind === "run") return;
  refreshCurves.request();
  refreshMetrics.request();
});

view.addEventListener("change", () => {
  showDownloads();
  if (JSON.stringify(question()) !== answered) refreshCurves.hurry();
  else draw();
});
document.addEventListener("themechange", draw);
at("cancel").addEventListener("click", cancel);
at("download-csv").addEventListener("click", downloadCsv);
at("copy-link").addEventListener("click", copyLink);
showDownloads();

async function loadSweep(signal) {
  const isFirst = sweep === null;
  try {
    sweep = await get(`/sweeps/${id}`, {}, signal);
  } catch (error) {
    if (error.status !== 404) throw error;
    showMissing(error.message);
    return;
  }
  showSweep();
  if (isFirst) draw();
  await runs.loadProblems(sweep.runs, signal);
}

/** What the service is asked for: only what changes its answer. */
function question() {
  const isReturn = RETURNS.includes(view.get("metric"));
  return {
    metric: view.get("metric"),
    normalized: isReturn && view.get("scale") === "normalized",
    band: view.get("band") === "none" ? "std" : view.get("band"),
    x: view.get("x"),
    max_points: MAX_POINTS,
    seeds: view.get("seeds"),
  };
}

async function loadCurves(signal) {
  const asked = question();
  at("curves").setAttribute("aria-busy", "true");
  comparison = await get(`/sweeps/${id}/curves`, asked, signal);
  answered = JSON.stringify(asked);
  at("curves").removeAttribute("aria-busy");
  at("loading").hidden = true;
  draw();
  connection.fresh();
}

/** What there is to show: learners differ in their diagnostics, and start one after the other. */
async function loadMetrics(signal) {
  controls.offerMetrics(await get(`/sweeps/${id}/metrics`, {}, signal));
}

function showSweep() {
  document.title = `${percent(sweep.progress)} · ${sweep.name} · d3pg`;
  setText(at("name"), sweep.name);
  at("summary").replaceChildren(summary(sweep), " · submitted ", timeElement(sweep.created_at));
  at("progress").value = sweep.progress;
  setText(at("percent"), percent(sweep.progress));
  const left = isActive(sweep) ? remaining(sweep.eta_seconds) : sweep.status;
  setText(at("remaining"), left);
  showCounts(sweep);
  at("cancel").hidden = !isActive(sweep);
}

/** Draw the latest answer, unless the person already asks for another. */
function draw() {
  if (sweep === null || comparison === null) return;
  if (JSON.stringify(question()) !== answered) return;
  const known = identities(comparison.panels);
  const axes = {
    xLabel: comparison.x,
    yLabel: comparison.normalized ? `normalised ${comparison.metric}` : comparison.metric,
    xMax: comparison.x === "timesteps" ? (sweep.request.timesteps ?? null) : null,
  };
  legend.update(known);
  showPanels(comparison.panels.map((panel) => ({ panel, known, axes })));
  setText(at("definition"), comparison.definition);
}

function showDownloads() {
  const { metric, ...parameters } = question();
  delete parameters.seeds;
  delete parameters.max_points;
  for (const form of ["png", "svg"]) {
    const link = at(`download-${form}`);
    link.href = address(`/sweeps/${id}/plot.${form}`, parameters);
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

async function cancel() {
  try {
    if (await cancelSweep(sweep)) refreshSweep.hurry();
  } catch (refusal) {
    connection.refused(refusal);
  }
}

function showMissing(message) {
  stream.close();
  setText(at("missing"), message);
  at("missing").hidden = false;
  at("curves").hidden = at("runs").hidden = true;
}
