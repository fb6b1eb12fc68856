/** What surrounds a run: its sweep, its siblings of other seeds, its task's scale, its settings. */
import { get } from "../connection/api.js";
import { at, element, setText } from "../parts/element.js";
import { number } from "../texts/format.js";
import { settings } from "../texts/schema.js";
import { givenValues, quantity, taskName } from "../texts/task.js";

const MOST_SEEDS = 200;

/**
 * @typedef {object} Context
 * @property {Api.Sweep} sweep
 * @property {Api.ListedRun[]} siblings   of the same entry and task, by seed
 * @property {Api.Panel["random_return"]} random
 * @property {Api.Environment["parameters"]} parameters   of its task, and those of noise that are given
 * @property {number | null} best   the return of the largest reward at every step
 * @property {Api.Algorithm | undefined} algorithm
 */

/**
 * @param {Api.Run} run
 * @param {AbortSignal} signal
 * @returns {Promise<Context>}
 */
export async function contextOf(run, signal) {
  const { sweep_id: id, algorithm, environment } = run;
  const ordinal = Number(run.id.slice(run.id.indexOf("-") + 1));
  const [sweep, runs, curves, catalogue] = await Promise.all([
    get(`/sweeps/${id}`, {}, signal),
    get(`/sweeps/${id}/runs`, { algorithm, environment, limit: MOST_SEEDS, sort: "seed" }, signal),
    get(`/sweeps/${id}/curves`, { run: ordinal, max_points: 2 }, signal),
    get("/catalogue", {}, signal),
  ]);
  const task = catalogue.environments.find(({ name }) => name === taskName(environment));
  return {
    sweep,
    siblings: runs.items.filter(({ label }) => label === run.label),
    random: curves.panels[0]?.random_return ?? null,
    parameters: [
      ...(task?.parameters ?? []),
      ...catalogue.parameters.filter(({ name }) => givenValues(environment).has(name)),
    ],
    best: task ? task.max_reward * task.horizon : null,
    algorithm: catalogue.algorithms.find(({ name }) => name === algorithm),
  };
}

/**
 * Where else one can go from a run: its sweep, and the other seeds.
 *
 * @param {Api.Run} run
 * @param {Context} context
 */
export function showSurroundings(run, { sweep, siblings }) {
  setText(at("sweep-link"), sweep.name);
  const choice = at("seeds", HTMLSelectElement);
  choice.replaceChildren(
    ...siblings.map(({ id, seed, status }) => element("option", { value: id }, `${seed}, ${status}`)),
  );
  choice.value = run.id;
  at("seed-choice").hidden = siblings.length < 2;
}

/**
 * The numbers that matter most, the score first.
 *
 * @param {Api.Run} run
 * @param {Context} context
 * @param {Record<string, (number | null)[]>} columns
 */
export function showKeyFigures(run, { siblings, random, best }, columns) {
  const score = siblings.find(({ id }) => id === run.id)?.score ?? null;
  const latest = columns.return_mean?.findLast((value) => value !== null) ?? null;
  const isScaled = random !== null && best !== null && latest !== null;
  const scaled = isScaled ? (latest - random.mean) / (best - random.mean) : null;
  const seconds = columns.seconds?.at(-1) ?? null;
  const compiled = columns.compile_seconds?.at(-1) ?? null;
  const memory = run.memory_bytes === null ? null : run.memory_bytes / 1e6;
  /** @type {[string, string][]} */
  const figures = [
    ["Score, normalised", score === null ? "end not reached" : number(score)],
    ["Latest return", number(latest)],
    ["normalised", number(scaled)],
    ["Processor time of training", seconds === null ? "–" : `${number(seconds)} s`],
    ["Processor time of compiling", compiled === null ? "–" : `${number(compiled)} s`],
    ["Memory, at most", memory === null ? "–" : `${number(memory)} MB`],
  ];
  at("key-figures").replaceChildren(
    ...figures.map(([name, value]) =>
      element("div", {}, element("dt", {}, name), element("dd", {}, value)),
    ),
  );
}

/**
 * Every setting that the learner runs with, and where it comes from.
 *
 * @param {Api.Run} run
 * @param {Context} context
 */
export function showSettings(run, { sweep, algorithm }) {
  if (algorithm === undefined) return;
  const stated = sweep.entries.find(({ label }) => label === run.label)?.stated ?? {};
  const rank = (/** @type {string} */ name) => (name in stated ? 0 : name in run.config ? 1 : 2);
  const rows = settings(algorithm.config_schema)
    .map(({ name, initial }) => ({ name, value: run.config[name] ?? initial, rank: rank(name) }))
    .toSorted((a, b) => a.rank - b.rank);
  at("settings").replaceChildren(
    ...rows.map(({ name, value, rank: from }) => {
      const text = typeof value === "number" ? number(value) : JSON.stringify(value ?? null);
      const origin = ["stated", "preset", ""][from];
      const shown = element(from === 0 ? "strong" : "span", {}, text);
      const mark = element("span", { class: "muted" }, origin ? ` ${origin}` : "");
      return element("div", {}, element("dt", {}, name), element("dd", {}, shown, mark));
    }),
  );
}

/**
 * The physical parameters of the run's task, and its noise where there is any.
 *
 * @param {Api.Run} run
 * @param {Context} context
 */
export function showParameters({ environment }, { parameters }) {
  const given = givenValues(environment);
  at("parameters-part").hidden = parameters.length === 0;
  at("parameters").replaceChildren(
    ...parameters.map((parameter) => {
      const isGiven = given.has(parameter.name);
      const text = quantity(given.get(parameter.name) ?? parameter.default, parameter);
      const value = element(isGiven ? "strong" : "span", {}, text);
      const mark = element("span", { class: "muted" }, isGiven ? " given" : "");
      return element("div", {}, element("dt", {}, parameter.name), element("dd", {}, value, mark));
    }),
  );
}

/**
 * What a run waits for while nothing is measured.
 *
 * @param {Api.Run} run
 * @returns {string}
 */
export function phaseText({ status, attempt }) {
  if (status === "queued" && attempt > 0) return "Waits for a worker that tries it again.";
  if (status === "queued") return "Waits for a worker; the page of workers shows the queue.";
  if (status === "paused") return "Paused: it waits to be resumed.";
  if (status === "running") return "Loading or compiling the learner’s kernels, then the first 800 timesteps.";
  return "Nothing was measured.";
}
