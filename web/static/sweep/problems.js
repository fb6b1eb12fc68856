/** What went wrong in a sweep, each reason once. */
import { get } from "../connection/api.js";
import { at, element, setText, within } from "../parts/element.js";
import { counted } from "../texts/format.js";
import { here } from "../texts/place.js";

const BAD = /** @type {const} */ (["failed", "diverged"]);
const LISTED = 20;
const REASONS_SHOWN = 8;

const box = at("problems");

/**
 * Say it; asks only when the counts moved.
 *
 * @param {Api.Sweep} sweep
 * @param {AbortSignal} signal
 */
export async function loadProblems(sweep, signal) {
  const statuses = BAD.filter((status) => sweep.runs[status] > 0);
  const parts = statuses.map((status) => `${counted(sweep.runs[status], "run")} ${status}`);
  const text = `${parts.join(", ")}.`;
  const summary = within(box, "p");
  box.hidden = statuses.length === 0;
  if (box.hidden || summary.textContent === text) return;
  const lists = statuses.map((status) =>
    get(`/sweeps/${sweep.id}/runs`, { status, limit: LISTED }, signal),
  );
  const runs = (await Promise.all(lists)).flatMap(({ items }) => items);
  setText(summary, text);
  within(box, "ul").replaceChildren(...reasons(runs));
}

/**
 * @param {Api.ListedRun[]} runs
 * @returns {HTMLElement[]}
 */
function reasons(runs) {
  /** @type {Map<string, Api.ListedRun[]>} */
  const groups = new Map();
  for (const run of runs) {
    const text = run.reason || "no reason was recorded";
    groups.set(text, [...(groups.get(text) ?? []), run]);
  }
  const shown = [...groups].slice(0, REASONS_SHOWN).map(([text, alike]) => {
    const [first] = alike;
    const others = alike.length > 1 ? ` and ${alike.length - 1} more` : "";
    const who = `${first.label} in ${first.environment}, seed ${first.seed}${others}`;
    const link = element("a", { href: here(`/runs/${first.id}`) }, who);
    return element("li", {}, link, ": ", element("span", { class: "reason" }, text));
  });
  const hidden = groups.size - shown.length;
  return hidden > 0 ? [...shown, element("li", {}, `${hidden} other reasons`)] : shown;
}
