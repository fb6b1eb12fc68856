/** The list of sweeps, newest first, as they progress. */
import { get, refusalOf } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Listing } from "../connection/paging.js";
import { Refresh } from "../connection/refresh.js";
import * as connection from "../connection/state.js";
import { at, element, keyed, setText, within } from "../parts/element.js";
import { statusCounts, timeElement } from "../parts/status.js";
import { text, View } from "../parts/view.js";
import { Submission } from "../submit/submission.js";
import { cancelSweep } from "../sweep/moves.js";
import { percent } from "../texts/format.js";
import { isActive, rowSummary, stateText } from "../texts/sweep.js";

const PAGE = 50;

const listing = new Listing((page, signal) => get("/sweeps", { ...page, limit: PAGE }, signal));
const showRows = keyed(within(document, "#sweeps tbody"), (sweep) => sweep.id, row);
const refresh = new Refresh(load, {
  interval: 1000,
  onError: (error) => connection.failed(error),
});

new Submission(new View({ new: text }));
follow("", () => refresh.request());
at("more").addEventListener("click", () => {
  listing.extend();
  refresh.hurry();
});

/** @param {AbortSignal} signal */
async function load(signal) {
  const { items, hasMore } = await listing.fetch(signal);
  showRows(items);
  at("loading").hidden = true;
  at("sweeps").hidden = items.length === 0;
  at("empty").hidden = items.length > 0;
  at("more").hidden = !hasMore;
  connection.fresh();
}

/**
 * @param {Api.ListedSweep} first
 * @returns {{ node: HTMLElement, update: (sweep: Api.ListedSweep) => void }}
 */
function row(first) {
  let sweep = first;
  const bar = element("progress", { max: "1" });
  const done = element("span", { class: "strong" });
  const left = element("span", { class: "muted" });
  const counts = element("ul", { class: "counts" });
  const showCounts = statusCounts(counts);
  const cancel = element("button", { type: "button", class: "quiet" }, "Cancel");
  cancel.setAttribute("aria-label", `Cancel ${sweep.name}`);
  cancel.addEventListener("click", async () => {
    try {
      if (await cancelSweep(sweep)) refresh.hurry();
    } catch (error) {
      connection.refused(refusalOf(error));
    }
  });
  const node = element(
    "tr",
    {},
    element(
      "th",
      { scope: "row" },
      element("a", { href: `/sweeps/${sweep.id}` }, sweep.name),
      element("span", { class: "muted" }, rowSummary(sweep)),
    ),
    element("td", { class: "progress-cell" }, bar, element("p", {}, done, " ", left)),
    element("td", {}, counts),
    element("td", { class: "when" }, timeElement(sweep.created_at)),
    element("td", { class: "actions-cell" }, cancel),
  );
  bar.setAttribute("aria-label", `Progress of ${sweep.name}`);
  const update = (/** @type {Api.ListedSweep} */ latest) => {
    sweep = latest;
    bar.value = sweep.progress;
    setText(done, percent(sweep.progress));
    setText(left, stateText(sweep));
    showCounts(sweep);
    cancel.hidden = !isActive(sweep);
  };
  return { node, update };
}
