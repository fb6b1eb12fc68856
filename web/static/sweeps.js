/** The list of sweeps, newest first, as they progress. */
import { address } from "./api.js";
import * as connection from "./connection.js";
import { element, keyed, setText } from "./element.js";
import { percent } from "./format.js";
import { follow } from "./live.js";
import { Listing } from "./paging.js";
import { Refresh } from "./refresh.js";
import { Submission } from "./submission.js";
import {
  cancelSweep,
  isActive,
  stateText,
  statusCounts,
  summary,
  timeElement,
  updateTimes,
} from "./sweep_text.js";
import { text, View } from "./view.js";

const PAGE = 50;
const at = (name) => document.getElementById(name);

const listing = new Listing("/sweeps", PAGE);
const showRows = keyed(at("sweeps").tBodies[0], (sweep) => sweep.id, row);
const refresh = new Refresh(load, {
  interval: 1000,
  onError: (error) => connection.failed(error),
});

new Submission(new View({ new: text }));
follow(address("/events"), () => refresh.request());
setInterval(updateTimes, 20_000);
at("more").addEventListener("click", () => {
  listing.extend();
  refresh.hurry();
});

async function load(signal) {
  const { items, hasMore } = await listing.fetch({}, signal);
  showRows(items);
  at("loading").hidden = true;
  at("sweeps").hidden = items.length === 0;
  at("empty").hidden = items.length > 0;
  at("more").hidden = !hasMore;
  connection.fresh();
}

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
    } catch (refusal) {
      connection.refused(refusal);
    }
  });
  const node = element(
    "tr",
    {},
    element(
      "th",
      { scope: "row" },
      element("a", { href: `/sweeps/${sweep.id}` }, sweep.name),
      element("span", { class: "muted" }, summary(sweep)),
    ),
    element("td", { class: "progress-cell" }, bar, element("p", {}, done, " ", left)),
    element("td", {}, counts),
    element("td", { class: "when" }, timeElement(sweep.created_at)),
    element("td", { class: "actions-cell" }, cancel),
  );
  bar.setAttribute("aria-label", `Progress of ${sweep.name}`);
  const update = (latest) => {
    sweep = latest;
    bar.value = sweep.progress;
    setText(done, percent(sweep.progress));
    setText(left, stateText(sweep));
    showCounts(sweep);
    cancel.hidden = !isActive(sweep);
  };
  return { node, update };
}
