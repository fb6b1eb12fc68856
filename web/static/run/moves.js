/** What a person does to a run: asked for once more where it stops something for good. */
import { post } from "../connection/api.js";
import { confirm } from "../parts/confirm.js";

/**
 * Cancel a run if the person means it. Throws Refusal.
 *
 * @param {Api.Run} run
 * @returns {Promise<boolean>}
 */
export async function cancelRun(run) {
  const meant = await confirm({
    title: "Cancel this run?",
    detail:
      `${run.label} in ${run.environment}, seed ${run.seed}, will stop for good. ` +
      "The other runs go on, and measurements stay.",
    yes: "Cancel the run",
    no: "Let it run",
  });
  if (meant) await post(`/runs/${run.id}/cancel`);
  return meant;
}

/**
 * Queue a failed run again. Throws Refusal.
 *
 * @param {Api.Run} run
 * @returns {Promise<Api.Run>}
 */
export function retryRun(run) {
  return post(`/runs/${run.id}/retry`);
}
