/** A sweep in words. */
import { count, counted, number, remaining } from "./format.js";

/**
 * "2 learners × 8 environments × 16 seeds, 20,000 timesteps", out of what was posted; "2 learners in
 * 8 environments: 15 curves × 16 seeds" where one takes no part somewhere.
 */
export function summary({ request }) {
  if (!Array.isArray(request?.algorithms)) return "";
  const weights = ({ weights }) => (Array.isArray(weights) ? weights.length : 1);
  const algorithms = request.algorithms.reduce((sum, each) => sum + weights(each), 0);
  const seeds = Array.isArray(request.seeds) ? request.seeds.length : request.seeds;
  const learners = counted(algorithms, "learner");
  const environments = counted(request.environments.length, "environment");
  const sum = (total, each) => total + weights(each) * (each.environments ?? request.environments).length;
  const curves = request.algorithms.reduce(sum, 0);
  const isWhole = curves === algorithms * request.environments.length;
  const product = isWhole
    ? `${learners} × ${environments} × ${counted(seeds, "seed")}`
    : `${learners} in ${environments}: ${counted(curves, "curve")} × ${counted(seeds, "seed")}`;
  const share = (request.scale ?? 1) < 1 ? `, ${number(100 * request.scale)} % of the timesteps` : "";
  const steps = request.timesteps ? `, ${count(request.timesteps)} timesteps` : "";
  return product + steps + share;
}

/** Whether there is anything left to cancel. */
export function isActive({ runs }) {
  return runs.queued + runs.running + runs.paused > 0;
}

/** "about 3 min left", "paused", or how it ended: "finished" only if every run did. */
export function stateText(sweep) {
  if (sweep.status === "paused") return "paused";
  if (isActive(sweep)) return remaining(sweep.eta_seconds);
  const { succeeded, total } = sweep.runs;
  const isWhole = sweep.status !== "finished" || succeeded === total;
  return isWhole ? sweep.status : `ended, ${count(succeeded)} of ${counted(total, "run")} finished`;
}

/** ["1 diverged", "2 running"], of counts by status. */
export function statusTexts(counts) {
  return Object.entries(counts).map(([status, number]) => `${count(number)} ${status}`);
}
