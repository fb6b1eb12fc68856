/**
 * Sweeps and runs as what a comparison shows of either: a name, settings, and panels of curves as
 * the service answers them for a sweep.
 */
import { get } from "../connection/api.js";
import { flat } from "../parts/facts.js";
import { here } from "../texts/place.js";

/**
 * @import { Question } from "../curves/question.js"
 *
 * @typedef {import("../parts/identity.js").Entry} Entry
 *
 * @typedef {object} Compared
 * @property {string} id
 * @property {string} name
 * @property {string} page
 * @property {[path: string, text: string][]} settings
 * @property {Entry[]} entries
 * @property {Api.Panel[]} panels
 */

/**
 * @param {string} id
 * @param {Question} question what is asked of its curves
 * @param {AbortSignal} signal
 * @returns {Promise<Compared>}
 */
export async function comparedSweep(id, question, signal) {
  const sweep = await get(`/sweeps/${id}`, {}, signal);
  const { panels } = await get(`/sweeps/${id}/curves`, question, signal);
  return {
    id,
    name: sweep.name,
    page: here(`/sweeps/${id}`),
    settings: flat(sweepSettings(sweep)),
    entries: sweep.entries,
    panels,
  };
}

/**
 * A run is a curve of one seed.
 *
 * @param {string} id
 * @param {Question} question what is asked of its curve
 * @param {AbortSignal} signal
 * @returns {Promise<Compared>}
 */
export async function comparedRun(id, question, signal) {
  const run = await get(`/runs/${id}`, {}, signal);
  const asked = { ...question, run: Number(id.slice(id.indexOf("-") + 1)) };
  const { panels } = await get(`/sweeps/${run.sweep_id}/curves`, asked, signal);
  const label = `${run.label}, seed ${run.seed}`;
  const { algorithm, environment, seed, timesteps, weights, config, fingerprint } = run;
  return {
    id,
    name: `run ${id}`,
    page: here(`/runs/${id}`),
    settings: flat({ algorithm, environment, seed, timesteps, ...weights, config, fingerprint }),
    entries: [{ label, algorithm }],
    panels: panels.map((panel) => ({
      ...panel,
      curves: panel.curves.map((curve) => ({ ...curve, label })),
    })),
  };
}

/**
 * @param {Api.Sweep} sweep
 * @returns {object}
 */
function sweepSettings(sweep) {
  /** @type {Api.Request} */
  const { algorithms = [], environments, seeds, timesteps, scale } = sweep.request;
  const learners = Object.fromEntries(
    algorithms.map(({ name, weights, config, environments: only }, i) => {
      const isAlone = algorithms.filter((other) => other.name === name).length === 1;
      const settings = { weights: weightsText(weights), ...(only ? { only } : {}), ...config };
      return [isAlone ? name : `${name} (${i + 1})`, settings];
    }),
  );
  const { priority } = sweep;
  const shared = { environments, seeds, timesteps: timesteps ?? "preset", scale: scale ?? 1 };
  return { ...shared, priority, ...learners };
}

/**
 * @param {Api.Weights | Api.Weights[] | null} [weights]
 * @returns {string | string[]}
 */
function weightsText(weights) {
  if (weights === undefined || weights === null) return "preset";
  return [weights].flat().map(({ w1 = 0, w2 = 0 }) => `(${w1}, ${w2})`);
}

/**
 * @param {Compared} compared
 * @returns {boolean}
 */
export function isSweep({ page }) {
  return page.startsWith("/sweeps/");
}

/**
 * The panels of all of them, environment by environment; a label says whose curve it is.
 *
 * @param {Compared[]} compared
 * @returns {Api.Panel[]}
 */
export function overlaid(compared) {
  /** @type {Map<string, Api.Panel>} */
  const panels = new Map();
  for (const one of compared) {
    for (const panel of one.panels) {
      const curves = panel.curves.map((curve) => labelled(curve, one, compared));
      const joined = panels.get(panel.environment) ?? { ...panel, curves: [] };
      panels.set(panel.environment, { ...joined, curves: [...joined.curves, ...curves] });
    }
  }
  return [...panels.values()];
}

/**
 * The entries of all of them, labelled as their curves are.
 *
 * @param {Compared[]} compared
 * @returns {Entry[]}
 */
export function overlaidEntries(compared) {
  return compared.flatMap((one) => one.entries.map((entry) => labelled(entry, one, compared)));
}

/**
 * Under a label that says whose it is, as the service has it (service/model/compared.py): equal
 * ones of two sweeps are told apart by their names, and sweeps of equal names by their ids.
 *
 * @template {{ label: string }} T
 * @param {T} thing
 * @param {Compared} owner
 * @param {Compared[]} compared
 * @returns {T}
 */
function labelled(thing, { id, name }, compared) {
  const isUnique = compared.filter((other) => other.name === name).length === 1;
  return { ...thing, label: `${thing.label} · ${isUnique ? name : `${name} (${id})`}` };
}
