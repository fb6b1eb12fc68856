/** What went wrong in a sweep, each reason once. */
import { Listing } from "../connection/paging.js";
import { element, setText } from "../parts/element.js";
import { counted } from "../texts/format.js";

const LISTED = 20;
const REASONS_SHOWN = 8;

const box = document.getElementById("problems");

/** Say it; asks only when the counts moved. */
export async function loadProblems(sweep, signal) {
  const statuses = ["failed", "diverged"].filter((status) => sweep.runs[status] > 0);
  const parts = statuses.map((status) => `${counted(sweep.runs[status], "run")} ${status}`);
  const text = `${parts.join(", ")}.`;
  const summary = box.querySelector("p");
  box.hidden = statuses.length === 0;
  if (box.hidden || summary.textContent === text) return;
  const path = `/sweeps/${sweep.id}/runs`;
  const lists = statuses.map((status) => new Listing(path, LISTED).fetch({ status }, signal));
  const runs = (await Promise.all(lists)).flatMap(({ items }) => items);
  setText(summary, text);
  box.querySelector("ul").replaceChildren(...reasons(runs));
}

function reasons(runs) {
  const groups = new Map();
  for (const run of runs) {
    const text = run.reason || "no reason was recorded";
    groups.set(text, [...(groups.get(text) ?? []), run]);
  }
  const shown = [...groups].slice(0, REASONS_SHOWN).map(([text, alike]) => {
    const [first] = alike;
    const others = alike.length > 1 ? ` and ${alike.length - 1} more` : "";
    const who = `${first.label} in ${first.environment}, seed ${first.seed}${others}`;
    const link = element("a", { href: `/runs/${first.id}` }, who);
    return element("li", {}, link, ": ", element("span", { class: "reason" }, text));
  });
  const hidden = groups.size - shown.length;
  return hidden > 0 ? [...shown, element("li", {}, `${hidden} other reasons`)] : shown;
}
