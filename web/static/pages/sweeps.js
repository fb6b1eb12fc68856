/** The list of sweeps, newest first, as they progress; found by words, tags, learners and tasks. */
import { Sparkline } from "../charts/sparkline.js";
import { get, refusalOf } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Listing } from "../connection/paging.js";
import { Refresh } from "../connection/refresh.js";
import * as connection from "../connection/state.js";
import { mayChange, ownerText } from "../parts/caller.js";
import { Controls } from "../parts/controls.js";
import { at, element, keyed, setText, within } from "../parts/element.js";
import { algorithmColour } from "../parts/palette.js";
import { SavedViews } from "../parts/saved_views.js";
import { statusCounts, timeElement } from "../parts/status.js";
import { list, oneOf, text, View } from "../parts/view.js";
import { Submission } from "../submit/submission.js";
import { cancelSweep } from "../sweep/moves.js";
import { PickedSweeps } from "../sweep/picked.js";
import { number, percent } from "../texts/format.js";
import { here } from "../texts/place.js";
import { isActive, namesText, rowSummary, stateText } from "../texts/sweep.js";

const PAGE = 50;

const view = new View({
  new: text, // the draft of the form
  q: text,
  tag: text,
  algorithm: text,
  environment: text,
  status: oneOf("any", "queued", "running", "paused", "finished", "cancelled"),
  archived: oneOf("false", "true", "all"),
  pick: list, // ids of the selected sweeps
});
const ASKED = /** @type {const} */ (["q", "tag", "algorithm", "environment", "status", "archived"]);

let listing = newListing();
const showRows = keyed(within(document, "#sweeps tbody"), (sweep) => sweep.id, row);
const refresh = new Refresh(load, {
  interval: 1000,
  onError: (error) => connection.failed(error),
});
const picked = new PickedSweeps(view, () => refresh.hurry());
/** @type {Api.ListedSweep[]} */
let listed = [];

new Submission(view);
new Controls(at("controls", HTMLFormElement), view);
new SavedViews(view, ASKED);
follow("", () => refresh.request());
offerNames();
view.onChange((fields) => {
  if (ASKED.some((field) => fields.includes(field))) {
    listing = newListing();
    refresh.hurry();
  } else if (fields.includes("pick")) showRows(listed);
});
at("more").addEventListener("click", () => {
  listing.extend();
  refresh.hurry();
});

function newListing() {
  const asked = Object.fromEntries(ASKED.map((field) => [field, view.get(field)]));
  if (asked.status === "any") delete asked.status;
  return new Listing((page, signal) => get("/sweeps", { ...asked, ...page, limit: PAGE }, signal));
}

/** @returns {boolean} whether some sweeps are asked for, and not all */
function isFiltered() {
  return ASKED.some((field) => !["", "any", "false"].includes(view.get(field)));
}

/** @param {AbortSignal} signal */
async function load(signal) {
  const { items, hasMore } = await listing.fetch(signal);
  listed = items;
  showRows(items);
  picked.keep(items.map(({ id }) => id));
  at("loading").hidden = true;
  at("controls").hidden = at("save-view").hidden = items.length === 0 && !isFiltered();
  at("sweeps").hidden = items.length === 0;
  at("none").hidden = items.length > 0 || !isFiltered();
  at("empty").hidden = items.length > 0 || isFiltered();
  at("more").hidden = !hasMore;
  connection.fresh();
}

/** What can be sought in the lists of learners and tasks. */
async function offerNames() {
  try {
    const { algorithms, environments } = await get("/catalogue");
    const option = (/** @type {{ name: string }} */ { name }) => element("option", { value: name });
    at("algorithm-names").replaceChildren(...algorithms.map(option));
    at("environment-names").replaceChildren(...environments.map(option));
  } catch (error) {
    refusalOf(error); // the names can be typed all the same
  }
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
  const box = element("input", { "type": "checkbox", "aria-label": `Select ${sweep.name}` });
  box.addEventListener("change", () => picked.pick(sweep.id, box.checked));
  const name = element("a", { href: here(`/sweeps/${sweep.id}`) });
  const tags = element("span", { class: "tags" });
  const best = bestCell();
  const owner = element("span", { class: "muted" });
  const node = element(
    "tr",
    {},
    element("td", { class: "pick-cell" }, box),
    element(
      "th",
      { scope: "row" },
      name,
      element("span", { class: "muted" }, rowSummary(sweep)),
      element("span", { class: "muted names" }, namesText(sweep)),
      tags,
    ),
    best.node,
    element("td", { class: "progress-cell" }, bar, element("p", {}, done, " ", left)),
    element("td", {}, counts),
    element("td", { class: "when" }, timeElement(sweep.created_at), owner),
    element("td", { "class": "actions-cell", "data-needs": "submit" }, cancel),
  );
  bar.setAttribute("aria-label", `Progress of ${sweep.name}`);
  const update = (/** @type {Api.ListedSweep} */ latest) => {
    sweep = latest;
    box.checked = view.get("pick").includes(sweep.id);
    setText(name, sweep.name);
    setText(owner, ownerText(sweep.owner) && ` ${ownerText(sweep.owner)}`);
    const labels = [...sweep.tags, ...(sweep.archived ? ["archived"] : [])];
    tags.replaceChildren(...labels.map((tag) => element("span", { class: "tag" }, tag)));
    best.update(sweep);
    bar.value = sweep.progress;
    setText(done, percent(sweep.progress));
    setText(left, stateText(sweep));
    showCounts(sweep);
    cancel.hidden = !isActive(sweep) || !mayChange(sweep.owner);
  };
  return { node, update };
}

/**
 * The best curve of a sweep: how high it came, how, where, and whose it is.
 *
 * @returns {{ node: HTMLElement, update: (sweep: Api.ListedSweep) => void }}
 */
function bestCell() {
  const score = element("span", { class: "strong" });
  const whose = element("span", { class: "muted" });
  const node = element("td", { class: "best-cell" });
  /** @type {Sparkline | null} */
  let sparkline = null;
  const update = (/** @type {Api.ListedSweep} */ { best, algorithms }) => {
    if (best === null) return;
    if (sparkline === null) {
      const algorithm = algorithms.find((each) => best.label.startsWith(each)) ?? best.label;
      sparkline = new Sparkline(algorithmColour(algorithm));
      node.append(element("p", {}, score, sparkline.node), whose);
    }
    setText(score, number(best.score));
    setText(whose, `${best.label} in ${best.environment}`);
    sparkline.update(best.sparkline, 1);
  };
  return { node, update };
}
