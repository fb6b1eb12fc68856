/**
 * Sweeps and runs as what a comparison shows of either: a name, settings, and panels of curves as
 * the service answers them for a sweep.
 */
import { get } from "../connection/api.js";
import { flat } from "../parts/facts.js";

/** @param question what is asked of a sweep's curves */
export async function comparedSweep(id, question, signal) {
  const sweep = await get(`/sweeps/${id}`, {}, signal);
  const { panels } = await get(`/sweeps/${id}/curves`, question, signal);
  return {
    id,
    name: sweep.name,
    page: `/sweeps/${id}`,
    settings: flat(sweepSettings(sweep)),
    entries: sweep.entries,
    panels,
  };
}

/** A run is a curve of one seed. */
export async function comparedRun(id, question, signal) {
  const run = await get(`/runs/${id}`, {}, signal);
  const ordinal = id.slice(id.indexOf("-") + 1);
  const curves = `/sweeps/${run.sweep_id}/curves`;
  const { panels } = await get(curves, { ...question, run: ordinal }, signal);
  const label = `${run.label}, seed ${run.seed}`;
  const { algorithm, environment, seed, timesteps, weights, config, fingerprint } = run;
  return {
    id,
    name: `run ${id}`,
    page: `/runs/${id}`,
    settings: flat({ algorithm, environment, seed, timesteps, ...weights, config, fingerprint }),
    entries: [{ label, algorithm }],
    panels: panels.map((panel) => ({
      ...panel,
      curves: panel.curves.map((curve) => ({ ...curve, label })),
    })),
  };
}

function sweepSettings({ request, priority }) {
  const { algorithms, environments, seeds, timesteps, scale } = request;
  const learners = Object.fromEntries(
    algorithms.map(({ name, weights, config, environments: only }, i) => {
      const isAlone = algorithms.filter((other) => other.name === name).length === 1;
      return [isAlone ? name : `${name} (${i + 1})`, { weights: weightsText(weights), ...(only ? { only } : {}), ...config }];
    }),
  );
  return { environments, seeds, timesteps: timesteps ?? "preset", scale: scale ?? 1, priority, ...learners };
}

function weightsText(weights) {
  if (weights === undefined || weights === null) return "preset";
  return [weights].flat().map(({ w1 = 0, w2 = 0 }) => `(${w1}, ${w2})`);
}

/** The panels of all of them, environment by environment; a label says whose curve it is. */
export function overlaid(compared) {
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

/** The entries of all of them, labelled as their curves are. */
export function overlaidEntries(compared) {
  return compared.flatMap((one) => one.entries.map((entry) => labelled(entry, one, compared)));
}

/** Under a label that says whose it is: equal ones of two sweeps are told apart by their names. */
function labelled(thing, { id, name }, compared) {
  const isUnique = compared.filter((other) => other.name === name).length === 1;
  return { ...thing, label: `${thing.label} · ${isUnique ? name : `${name} (${id})`}` };
}
