/** A run in words, and what can be done to it as it stands. */
import { duration } from "./format.js";

/**
 * @param {Pick<Api.Run, "status" | "is_cancelling">} run
 * @returns {string}
 */
export function statusText({ status, is_cancelling: isCancelling }) {
  return isCancelling && status === "running" ? "cancelling" : status;
}

/**
 * Whether its worker is not past the first cycle of this attempt yet: it loads the learner's
 * kernels, or compiles them, which takes minutes once on a machine.
 *
 * @param {Api.Run} run
 * @returns {boolean}
 */
function isPreparing({ status, timestep, resumed_timestep: from, checkpoint_timestep: newest }) {
  return status === "running" && timestep <= (from ?? newest);
}

/**
 * What a run that runs is at, where it does not train yet; else "".
 *
 * @param {Api.Run} run
 * @returns {string}
 */
export function activityText(run) {
  return isPreparing(run) && !run.is_cancelling ? "compiling or loading kernels" : "";
}

/**
 * How long workers worked on it, waits between attempts left out; "" while it has not ended.
 *
 * @param {Pick<Api.Run, "worked_seconds" | "finished_at">} run
 * @returns {string}
 */
export function tookText({ worked_seconds: seconds, finished_at: end }) {
  return end && seconds !== null ? duration(seconds) : "";
}

/**
 * @param {Api.Run} run
 * @returns {boolean}
 */
export function canCancel(run) {
  return ["queued", "running", "paused"].includes(run.status) && !run.is_cancelling;
}

/**
 * Whether it can be tried again: one that diverged would again.
 *
 * @param {Api.Run} run
 * @returns {boolean}
 */
export function canRetry(run) {
  return run.status === "failed";
}
