/** A run's page: where it stands, what it measured and diagnosed, its attempts and settings. */
import { address, get } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Refresh } from "../connection/refresh.js";
import * as connection from "../connection/state.js";
import { Controls } from "../parts/controls.js";
import { setText } from "../parts/element.js";
import { showFacts } from "../parts/facts.js";
import { statusMark, timeElement } from "../parts/status.js";
import { CURVE_FIELDS, oneOf, View, whole } from "../parts/view.js";
import { attemptList } from "../run/attempts.js";
import { RunCharts } from "../run/charts.js";
import { cancelRun, retryRun } from "../run/moves.js";
import { Viewer } from "../run/viewer.js";
import { count, percent } from "../texts/format.js";
import { canCancel, canRetry, statusText, tookText } from "../texts/run.js";

const id = document.getElementById("run").dataset.run;
const at = (name) => document.getElementById(name);

const view = new View({
  ...CURVE_FIELDS,
  start: whole, // of the episode in the viewer: which the task draws
  step: whole,
  speed: oneOf("1", "0.25", "0.5", "2", "4"),
});
new Controls(at("controls"), view);
const charts = new RunCharts(at("charts"), view);
const showAttempts = attemptList(at("attempts"));
const onError = (error) => connection.failed(error);
const refreshRun = new Refresh(loadRun, { interval: 1000, onError });
const viewer = new Viewer(view, () => refreshRun.hurry());
const refreshCurves = new Refresh(loadCurves, { interval: 1000, onError });

let run = null;
let columns = null;

const stream = follow(address(`/sweeps/${id.split("-")[0]}/events`), (kind, payload) => {
  if (payload?.run_id !== undefined && payload.run_id !== id) return;
  refreshRun.request();
  refreshCurves.request();
});

view.addEventListener("change", draw);
document.addEventListener("themechange", draw);
at("cancel").addEventListener("click", () => act(() => cancelRun(run)));
at("retry").addEventListener("click", () => act(() => retryRun(run)));
at("download-json").href = address(`/runs/${id}/measurements`);
at("download-csv").href = address(`/runs/${id}/measurements`, { format: "csv" });

async function loadRun(signal) {
  try {
    run = await get(`/runs/${id}`, {}, signal);
  } catch (error) {
    if (error.status !== 404) throw error;
    showMissing(error.message);
    return;
  }
  showRun();
  draw();
  const attempts = await get(`/runs/${id}/attempts`, {}, signal);
  showAttempts(attempts);
  at("no-attempts").hidden = attempts.length > 0;
  await viewer.load(run, signal);
}

async function loadCurves(signal) {
  try {
    ({ columns } = await get(`/runs/${id}/measurements`, {}, signal));
  } catch (error) {
    if (error.status !== 404) throw error;
    return;
  }
  at("loading").hidden = true;
  draw();
  connection.fresh();
}

function draw() {
  if (run !== null && columns !== null) charts.update(run, columns);
}

function showRun() {
  const title = `${run.label} in ${run.environment}, seed ${run.seed}`;
  const done = run.timestep / run.timesteps;
  document.title = `${percent(done)} · ${title} · d3pg`;
  setText(at("name"), title);
  at("sweep-link").href = `/sweeps/${run.sweep_id}`;
  setText(at("sweep-link"), `sweep ${run.sweep_id}`);
  at("runs-link").href = `/sweeps/${run.sweep_id}/runs`;
  at("progress").value = done;
  setText(at("percent"), percent(done));
  setText(at("timesteps"), `${count(run.timestep)} of ${count(run.timesteps)} timesteps`);
  at("status").replaceChildren(statusMark(run.status), ...statusParts());
  setText(at("reason"), run.reason);
  at("reason").hidden = run.reason === "";
  at("cancel").hidden = !canCancel(run);
  at("retry").hidden = !canRetry(run);
  const { algorithm, environment, environment_version: version, seed, weights, config } = run;
  const task = `${environment}, version ${version}`;
  showFacts(at("config"), { algorithm, environment: task, seed, ...weights, ...config });
  showCheckpoints();
  showFacts(at("fingerprint"), run.fingerprint ?? { "not reported yet": "" });
}

/** Where it could be taken up again, where the service says so. */
function showCheckpoints() {
  const { checkpoint_timestep: newest, resumed_timestep: resumed } = run;
  at("checkpoints").hidden = newest === undefined;
  showFacts(at("checkpoint-list"), {
    "newest at timestep": newest > 0 ? count(newest) : "none",
    "taken up at timestep": resumed > 0 ? count(resumed) : "from the start",
  });
}

/** "running, attempt 2, submitted 3 min ago". */
function statusParts() {
  const took = tookText(run);
  const parts = [statusText(run)];
  if (run.attempt > 1) parts.push(`attempt ${run.attempt}`);
  if (took) parts.push(`took ${took}`);
  return [`${parts.join(", ")}, submitted `, timeElement(run.created_at)];
}

async function act(action) {
  try {
    if (await action()) refreshRun.hurry();
  } catch (refusal) {
    connection.refused(refusal);
  }
}

function showMissing(message) {
  stream.close();
  setText(at("missing"), message);
  at("missing").hidden = false;
  at("body").hidden = true;
}
