/** What a person does to a sweep: asked for once more where it stops something for good. */
import { post, remove } from "../connection/api.js";
import { confirm } from "../parts/confirm.js";
import { counted } from "../texts/format.js";

/**
 * Cancel a sweep if the person means it. Throws Refusal.
 *
 * @param {Api.SweepHead} sweep
 * @returns {Promise<boolean>}
 */
export async function cancelSweep(sweep) {
  const stopping = /** @type {const} */ (["running", "queued", "paused"])
    .filter((status) => sweep.runs[status] > 0)
    .map((status) => counted(sweep.runs[status], `${status} run`));
  const meant = await confirm({
    title: `Cancel “${sweep.name}”?`,
    detail: `${stopping.join(" and ")} will stop for good. Measurements stay.`,
    yes: "Cancel the sweep",
    no: "Let it run",
  });
  if (meant) await post(`/sweeps/${sweep.id}/cancel`);
  return meant;
}

/**
 * Delete a sweep if the person means it. Throws Refusal.
 *
 * @param {Api.Sweep} sweep
 * @returns {Promise<boolean>}
 */
export async function deleteSweep({ id, name, runs }) {
  const meant = await confirm({
    title: `Delete “${name}”?`,
    detail: `This deletes its ${counted(runs.total, "run")} for good, with measurements and policies.`,
    yes: "Delete the sweep",
    no: "Keep it",
  });
  if (meant) await remove(`/sweeps/${id}`);
  return meant;
}
