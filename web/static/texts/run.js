/** A run in words, and what can be done to it as it stands. */
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
