/** A sweep in words. */
import { count, counted, number, remaining } from "./format.js";

/**
 * "2 learners × 8 environments × 16 seeds, 20,000 timesteps", out of what was posted; "2 learners in
 * 8 environments: 15 curves × 16 seeds" where one takes no part somewhere.
 *
 * @param {Api.Sweep} sweep
 * @returns {string}
 */
export function summary(sweep) {
  /** @type {Api.Request} */
  const { environments, seeds = 0, timesteps, scale = 1 } = sweep.request;
  if (!Array.isArray(environments)) return "";
  const entries = sweep.entries.length;
  const parts = [counted(entries, "learner"), counted(environments.length, "environment")];
  const steps = timesteps ? `, ${count(timesteps)} timesteps` : "";
  const shares = [scale].flat().map((each) => number(100 * each));
  const share = scale === 1 ? "" : `, ${shares.join(" and ")} % of the timesteps`;
  if (sweep.request.search) {
    return `search among ${parts.join(" × ")}, ${counted(sweep.runs.total, "run")}${steps}${share}`;
  }
  const repeats = Array.isArray(seeds) ? seeds.length : seeds;
  const curves = sweep.runs.total / repeats;
  const isAsked = Boolean(sweep.request.question); // then it gets as many seeds as that takes
  const of = counted(repeats, "seed") + (isAsked ? " or more" : "");
  const isWhole = isAsked || curves === entries * environments.length;
  const product = isWhole ? parts.join(" × ") : `${parts.join(" in ")}: ${counted(curves, "curve")}`;
  return `${product} × ${of}${steps}${share}`;
}

/**
 * "2 learners × 8 environments × 16 seeds", of a row of the list.
 *
 * @param {Api.ListedSweep} sweep
 * @returns {string}
 */
export function rowSummary({ entry_count: entries, environments, seeds, timesteps }) {
  const parts = [counted(entries, "learner"), counted(environments.length, "environment")];
  const steps = timesteps ? `, ${count(timesteps)} timesteps` : "";
  return [...parts, counted(seeds, "seed")].join(" × ") + steps;
}

/**
 * "ddpg, hybrid-ddpg and 3 more in Pendulum, CartPole".
 *
 * @param {Api.ListedSweep} sweep
 * @returns {string}
 */
export function namesText({ algorithms, environments }) {
  return `${few(algorithms)} in ${few(environments)}`;
}

const FEW = 3;

/**
 * @param {string[]} names
 * @returns {string}
 */
function few(names) {
  if (names.length <= FEW) return names.join(", ");
  return `${names.slice(0, FEW - 1).join(", ")} and ${names.length - FEW + 1} more`;
}

/**
 * Whether there is anything left to cancel.
 *
 * @param {Api.SweepHead} sweep
 * @returns {boolean}
 */
export function isActive({ runs, status }) {
  return runs.queued + runs.running + runs.paused > 0 || status === "running"; // between two batches
}

/**
 * "about 3 min left", "paused", or how it ended: "finished" only if every run did.
 *
 * @param {Api.SweepHead} sweep
 * @returns {string}
 */
export function stateText(sweep) {
  if (sweep.status === "paused") return "paused";
  if (isActive(sweep)) return remaining(sweep.eta_seconds);
  const { succeeded, total } = sweep.runs;
  const isWhole = sweep.status !== "finished" || succeeded === total;
  return isWhole ? sweep.status : `ended, ${count(succeeded)} of ${counted(total, "run")} finished`;
}

/**
 * ["1 diverged", "2 running"], of counts by status.
 *
 * @param {Record<string, number>} counts
 * @returns {string[]}
 */
export function statusTexts(counts) {
  return Object.entries(counts).map(([status, number]) => `${count(number)} ${status}`);
}
