/** Workers and the queue: who trains what, since when, what waits and why. */
import { get } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Refresh } from "../connection/refresh.js";
import * as connection from "../connection/state.js";
import { at, element, setText } from "../parts/element.js";
import { statusMark, timeElement } from "../parts/status.js";
import { count, counted, percent } from "../texts/format.js";
import { here } from "../texts/place.js";

/** @typedef {Api.Workers["workers"][number]} Worker */
/** @typedef {Api.Workers["waiting"][number]} Waiting */

const WORKER_HEADS = ["Worker", "Trains", "Task", "Runs", "Done", "Since"];
const QUEUE_HEADS = ["Sweep", "Runs", "Priority", "Submitted", "Why it waits"];

const refresh = new Refresh(load, {
  interval: 2000,
  onError: (error) => connection.failed(error),
});
follow("", () => refresh.request());

/** @param {AbortSignal} signal */
async function load(signal) {
  const { problem, workers, waiting } = await get("/workers", {}, signal);
  setText(at("problem"), problem ?? "");
  at("problem").hidden = problem === null;
  at("no-workers").hidden = workers.length > 0;
  at("no-queue").hidden = waiting.length > 0;
  fill(at("workers"), WORKER_HEADS, workers.flatMap(workerRows));
  fill(at("queue"), QUEUE_HEADS, waiting.map(waitingRow));
  at("loading").hidden = true;
  at("body").hidden = false;
  connection.fresh();
}

/**
 * @param {HTMLElement} table
 * @param {string[]} heads
 * @param {HTMLElement[]} rows
 */
function fill(table, heads, rows) {
  const head = heads.map((text) => element("th", { scope: "col" }, text));
  table.hidden = rows.length === 0;
  table.replaceChildren(
    element("thead", {}, element("tr", {}, ...head)),
    element("tbody", {}, ...rows),
  );
}

/**
 * @param {Worker} worker
 * @returns {HTMLElement[]}
 */
function workerRows({ name, training }) {
  if (training.length > 0) return training.map((each) => trainingRow(name, each));
  const head = element("th", { scope: "row" }, statusMark("queued"), name);
  return [element("tr", {}, head, element("td", { class: "muted", colspan: "5" }, "idle"))];
}

/**
 * @param {string} name
 * @param {Worker["training"][number]} training
 * @returns {HTMLElement}
 */
function trainingRow(name, training) {
  const head = element("th", { scope: "row" }, statusMark("running"), name);
  const sweep = element("a", { href: here(`/sweeps/${training.sweep_id}`) }, training.sweep_name);
  const run = element("a", { href: here(`/runs/${training.first_run}`) }, counted(training.runs, "run"));
  return element(
    "tr",
    {},
    head,
    element("td", {}, `${training.label}, of `, sweep),
    element("td", {}, training.environment),
    element("td", {}, run),
    element("td", { class: "number" }, percent(training.timestep / training.timesteps)),
    element("td", {}, timeElement(training.since)),
  );
}

/**
 * @param {Waiting} waiting
 * @returns {HTMLElement}
 */
function waitingRow({ sweep_id: id, sweep_name: name, runs, priority, since, reason }) {
  return element(
    "tr",
    {},
    element("th", { scope: "row" }, element("a", { href: here(`/sweeps/${id}`) }, name)),
    element("td", { class: "number" }, count(runs)),
    element("td", { class: "number" }, String(priority)),
    element("td", {}, timeElement(since)),
    element("td", { class: "reason" }, reason),
  );
}
