/** A run's page: where it stands, what it measured and diagnosed, its attempts and settings. */
import { address, get, refusalOf } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Refresh } from "../connection/refresh.js";
import * as connection from "../connection/state.js";
import { DiagnosisSection } from "../diagnosis/section.js";
import { Controls } from "../parts/controls.js";
import { at, setText } from "../parts/element.js";
import { showFacts } from "../parts/facts.js";
import { statusMark, timeElement } from "../parts/status.js";
import { CURVE_FIELDS, oneOf, View, whole } from "../parts/view.js";
import { attemptList } from "../run/attempts.js";
import { RunCharts } from "../run/charts.js";
import {
  contextOf,
  phaseText,
  showKeyFigures,
  showParameters,
  showSettings,
  showSurroundings,
} from "../run/context.js";
import { cancelRun, retryRun } from "../run/moves.js";
import { Viewer } from "../run/viewer.js";
import { count, percent } from "../texts/format.js";
import { here } from "../texts/place.js";
import { activityText, canCancel, canRetry, statusText, tookText } from "../texts/run.js";

/** @import { Kind, Payload } from "../connection/broadcast.js" */
/** @import { Columns } from "../run/diagnostics.js" */

const id = at("run").dataset.run ?? "";

const view = new View({
  ...CURVE_FIELDS,
  start: whole, // of the episode in the viewer: which the task draws
  step: whole,
  speed: oneOf("1", "0.25", "0.5", "2", "4"),
});
new Controls(at("controls", HTMLFormElement), view);
const charts = new RunCharts(at("charts"), view);
const showAttempts = attemptList(at("attempts"));
const onError = (/** @type {Error} */ error) => connection.failed(error);
const refreshRun = new Refresh(loadRun, { interval: 1000, onError });
const viewer = new Viewer(view, () => refreshRun.hurry());
const refreshCurves = new Refresh(loadCurves, { interval: 1000, onError });
const refreshAttempts = new Refresh(loadAttempts, { interval: 1000, onError });
const diagnosis = new DiagnosisSection(`/runs/${id}`, () => refreshDiagnosis.hurry());
const refreshDiagnosis = new Refresh((signal) => diagnosis.load(signal), {
  interval: 1000,
  onError,
});

/** @type {Api.Run | null} */
let run = null;
/** @type {Columns | null} */
let columns = null;
/** @type {string | null} */
let seenEnd = null;
/** @type {import("../run/context.js").Context | null} */
let context = null; // of the run as it was opened; again when it ends

const stream = follow(id.split("-")[0], changed, ({ run_ids: ids = [] }) => {
  if (ids.includes(id)) refreshAttempts.request();
});

at("seeds").addEventListener("change", (event) => {
  const { value } = /** @type {HTMLSelectElement} */ (event.target);
  location.assign(here(`/runs/${value}${location.search}`));
});
view.onChange(draw);
document.addEventListener("themechange", draw);
at("cancel").addEventListener("click", () => act(cancelRun));
at("retry").addEventListener("click", () => act(retryRun));
at("download-json", HTMLAnchorElement).href = address(`/runs/${id}/measurements`);
at("download-policy", HTMLAnchorElement).href = address(`/runs/${id}/policy`);
at("download-csv", HTMLAnchorElement).href = address(`/runs/${id}/measurements`, { format: "csv" });

/**
 * @param {Kind} kind
 * @param {Payload} [payload]
 */
function changed(kind, payload) {
  if (payload?.run_id !== undefined && payload.run_id !== id) return;
  if (kind !== "measurements") refreshDiagnosis.request();
  if (kind === "diagnosis") return;
  refreshRun.request();
  refreshAttempts.request();
  refreshCurves.request();
}

/** @param {AbortSignal} signal */
async function loadRun(signal) {
  try {
    run = await get(`/runs/${id}`, {}, signal);
  } catch (error) {
    showMissing(refusalOf(error, 404).message);
    return;
  }
  showRun(run);
  context ??= await contextOf(run, signal);
  draw();
  await viewer.load(run, signal);
}

/** @param {AbortSignal} signal */
async function loadAttempts(signal) {
  try {
    const attempts = await get(`/runs/${id}/attempts`, {}, signal);
    showAttempts(attempts);
    at("no-attempts").hidden = attempts.length > 0;
  } catch (error) {
    refusalOf(error, 404); // which is told where the run is loaded
  }
}

/** @param {AbortSignal} signal */
async function loadCurves(signal) {
  try {
    const answer = await get(`/runs/${id}/measurements`, {}, signal);
    columns = /** @type {Columns} */ (answer.columns);
  } catch (error) {
    refusalOf(error, 404); // which is told where the run is loaded
    return;
  }
  draw();
  connection.fresh();
}

function draw() {
  if (run === null || columns === null || context === null) return;
  charts.update(run, columns, context);
  showSurroundings(run, context);
  showKeyFigures(run, context, columns);
  showSettings(run, context);
  showParameters(run, context);
  const isEmpty = (columns.timestep ?? []).length === 0;
  at("loading").hidden = !isEmpty;
  setText(at("loading"), isEmpty ? phaseText(run) : "");
}

/** @param {Api.Run} run */
function showRun(run) {
  if (context?.sweep && run.finished_at !== seenEnd) context = null;
  seenEnd = run.finished_at;
  const title = `${run.label} in ${run.environment}, seed ${run.seed}`;
  const done = run.timestep / run.timesteps;
  document.title = `${percent(done)} · ${title} · d3pg`;
  setText(at("name"), title);
  at("sweep-link", HTMLAnchorElement).href = here(`/sweeps/${run.sweep_id}`);
  at("runs-link", HTMLAnchorElement).href = here(`/sweeps/${run.sweep_id}/runs`);
  at("progress", HTMLProgressElement).value = done;
  setText(at("percent"), percent(done));
  setText(at("timesteps"), `${count(run.timestep)} of ${count(run.timesteps)} timesteps`);
  at("status").replaceChildren(statusMark(run.status), ...statusParts(run));
  setText(at("reason"), run.reason);
  at("reason").hidden = run.reason === "";
  at("cancel").hidden = !canCancel(run);
  at("retry").hidden = !canRetry(run);
  const { algorithm, environment, environment_version: version, seed, weights, config } = run;
  const task = `${environment}, version ${version}`;
  showFacts(at("config"), { algorithm, environment: task, seed, ...weights, ...config });
  showCheckpoints(run);
  showFacts(at("fingerprint"), run.fingerprint ?? { "not reported yet": "" });
}

/**
 * Where it could be taken up again.
 *
 * @param {Api.Run} run
 */
function showCheckpoints({ checkpoint_timestep: newest, resumed_timestep: resumed }) {
  at("checkpoints").hidden = false;
  showFacts(at("checkpoint-list"), {
    "newest at timestep": newest > 0 ? count(newest) : "none",
    "resumed at timestep": resumed ? count(resumed) : "from the start",
  });
}

/**
 * "running, attempt 2, submitted 3 min ago".
 *
 * @param {Api.Run} run
 * @returns {(Node | string)[]}
 */
function statusParts(run) {
  const took = tookText(run);
  const activity = activityText(run);
  const parts = [statusText(run)];
  if (activity) parts.push(activity);
  if (run.attempt > 1) parts.push(`attempt ${run.attempt}`);
  if (took) parts.push(`took ${took}`);
  return [`${parts.join(", ")}, submitted `, timeElement(run.created_at)];
}

/** @param {(run: Api.Run) => Promise<unknown>} action */
async function act(action) {
  if (run === null) return;
  try {
    if (await action(run)) refreshRun.hurry();
  } catch (error) {
    connection.refused(refusalOf(error));
  }
}

/** @param {string} message */
function showMissing(message) {
  stream.close();
  setText(at("missing"), message);
  at("missing").hidden = false;
  at("body").hidden = true;
}
