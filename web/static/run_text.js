/** A run in words, and what can be done to it: what lists and the run's own page share. */
import { post } from "./api.js";
import { confirm } from "./confirm.js";
import { duration } from "./format.js";

export function statusText({ status, is_cancelling: isCancelling }) {
  return isCancelling && status === "running" ? "cancelling" : status;
}

/** How long it took from its first start to its end; "" while it has not ended. */
export function tookText({ started_at: start, finished_at: end }) {
  return start && end ? duration((new Date(end) - new Date(start)) / 1000) : "";
}

export function canCancel(run) {
  return ["queued", "running", "paused"].includes(run.status) && !run.is_cancelling;
}

/** Whether it can be tried again: one that diverged would again. */
export function canRetry(run) {
  return run.status === "failed";
}

/** Cancel a run if the person means it. Throws Refusal. */
export async function cancelRun(run) {
  const meant = await confirm({
    title: "Cancel this run?",
    detail:
      `${run.label} in ${run.environment}, seed ${run.seed}, will stop for good. ` +
      "The other runs go on, and what was measured stays.",
    yes: "Cancel the run",
    no: "Let it run",
  });
  if (meant) await post(`/runs/${run.id}/cancel`);
  return meant;
}

/** Queue a failed run again. Throws Refusal. */
export function retryRun(run) {
  return post(`/runs/${run.id}/retry`);
}
