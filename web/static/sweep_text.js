/** A sweep in words, and its cancelling: what the list and the sweep's own page share. */
import { post } from "./api.js";
import { confirm } from "./confirm.js";
import { element, keyed, setText } from "./element.js";
import { ago, count, counted, dateAndTime, number, remaining } from "./format.js";

const STATUSES = ["running", "queued", "paused", "succeeded", "failed", "diverged", "cancelled"];

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

/** A list of "3 running" entries that keeps up with a sweep's counts; statuses of 0 are left out. */
export function statusCounts(list) {
  const show = keyed(
    list,
    ({ status }) => status,
    ({ status }) => {
      const text = element("span");
      const node = element("li", {}, statusMark(status), text);
      return { node, update: ({ amount }) => setText(text, `${count(amount)} ${status}`) };
    },
  );
  return ({ runs }) =>
    show(
      STATUSES.map((status) => ({ status, amount: runs[status] })).filter(({ amount }) => amount > 0),
    );
}

/** A dot in the colour and shape of a status; the word stands beside it. */
export function statusMark(status) {
  return element("span", { "class": "mark", "data-status": status, "aria-hidden": "true" });
}

/** A `<time>` that reads "3 min ago" and grows older by itself through `updateTimes`. */
export function timeElement(iso) {
  const date = new Date(iso);
  return element("time", { datetime: iso, title: dateAndTime(date) }, ago(date));
}

/** Let every time on the page say how long ago it is now. */
export function updateTimes() {
  for (const time of document.querySelectorAll("time")) setText(time, ago(new Date(time.dateTime)));
}

/** Cancel a sweep if the person means it. Throws Refusal. */
export async function cancelSweep(sweep) {
  const stopping = ["running", "queued", "paused"]
    .filter((status) => sweep.runs[status] > 0)
    .map((status) => counted(sweep.runs[status], `${status} run`));
  const meant = await confirm({
    title: `Cancel “${sweep.name}”?`,
    detail: `${stopping.join(" and ")} will stop for good. What was measured stays.`,
    yes: "Cancel the sweep",
    no: "Let it run",
  });
  if (meant) await post(`/sweeps/${sweep.id}/cancel`);
  return meant;
}
