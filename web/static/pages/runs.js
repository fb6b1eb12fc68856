/** The runs of a sweep: a page of them at a time, filtered and sorted by the service. */
import { get } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Refresh } from "../connection/refresh.js";
import * as connection from "../connection/state.js";
import { Controls } from "../parts/controls.js";
import { at, element, field, setText, within } from "../parts/element.js";
import { varied } from "../parts/identity.js";
import { flag, list, oneOf, text, View } from "../parts/view.js";
import { RunList } from "../run/list.js";
import { Picked } from "../run/picked.js";
import { Growth } from "../submit/growth.js";
import { SweepHead } from "../sweep/head.js";
import { count } from "../texts/format.js";

const PAGE = 100;
const SPARKLINE_POINTS = 40;
const id = at("sweep").dataset.sweep ?? "";
const pickAll = at("pick-all", HTMLInputElement);
const form = at("controls", HTMLFormElement);

const SORTS = /** @type {const} */ ([
  "made",
  "entry",
  "seed",
  "w1",
  "w2",
  "score",
  "return_mean",
  "timestep",
  "seconds",
]);
/** @type {Set<string>} */
const LARGEST_FIRST = new Set(["score", "return_mean", "timestep", "seconds"]);

const view = new View({
  status: oneOf("all", "running", "queued", "paused", "succeeded", "failed", "diverged", "cancelled"),
  algorithm: text,
  environment: text,
  sort: oneOf(...SORTS),
  descending: flag,
  after: list, // the cursors of the pages before this one
  pick: list, // ids of the selected runs
});
const SORTABLE = new Set(["w1", "w2"]); // of the settings that have a column
const ASKED = ["status", "algorithm", "environment", "sort", "descending"];

const controls = new Controls(form, view);
const runs = new RunList(within(document, ".runs tbody"), view, () => refreshRuns.hurry());
const onError = (/** @type {Error} */ error) => connection.failed(error);
const refreshSweep = new Refresh(loadSweep, { interval: 1000, onError });
const refreshRuns = new Refresh(loadRuns, { interval: 2000, onError });
const picked = new Picked(view, () => refreshRuns.hurry());
const head = new SweepHead(id, " · runs", () => refreshSweep.hurry(), hideRuns);
const growth = new Growth(id, () => refreshSweep.hurry());

/** @type {Api.ListedRun[]} */
let listed = [];
/** @type {string | null} */
let next = null; // the cursor of the page after this one

const stream = follow(id, () => {
  refreshSweep.request();
  refreshRuns.request();
});

view.onChange((fields) => {
  if (ASKED.some((field) => fields.includes(field)) && !fields.includes("after")) {
    view.set({ after: [] });
  } else if (fields.includes("after")) {
    refreshRuns.hurry();
  } else {
    showRuns();
  }
});
at("next").addEventListener("click", () => {
  if (next !== null) turn([...view.get("after"), next]);
});
at("previous").addEventListener("click", () => turn(view.get("after").slice(0, -1)));
pickAll.addEventListener("change", () => {
  const here = listed.map((run) => run.id);
  const elsewhere = view.get("pick").filter((each) => !here.includes(each));
  view.set({ pick: pickAll.checked ? [...elsewhere, ...here] : elsewhere });
});

/** @param {AbortSignal} signal */
async function loadSweep(signal) {
  await head.load(signal);
  if (head.sweep === null) return;
  growth.show(head.sweep);
  /** @type {Api.Request} */
  const { algorithms, environments } = head.sweep.request;
  offer("algorithm", algorithms?.map(({ name }) => name) ?? []);
  offer("environment", environments ?? []);
  showRuns();
}

/** @param {AbortSignal} signal */
async function loadRuns(signal) {
  const chosen = view.get("status");
  const answer = await get(
    `/sweeps/${id}/runs`,
    {
      status: chosen === "all" ? null : chosen,
      algorithm: view.get("algorithm"),
      environment: view.get("environment"),
      sort: view.get("sort"),
      descending: view.get("descending"),
      after: view.get("after").at(-1),
      limit: PAGE,
      sparkline: SPARKLINE_POINTS,
    },
    signal,
  );
  listed = answer.items;
  next = answer.next;
  showRuns();
  connection.fresh();
}

function showRuns() {
  const entries = head.sweep?.entries ?? [];
  showHeads(varied(entries));
  runs.show(listed, entries);
  picked.update();
  const pickedHere = listed.filter((run) => view.get("pick").includes(run.id)).length;
  pickAll.checked = pickedHere > 0 && pickedHere === listed.length;
  pickAll.indeterminate = pickedHere > 0 && pickedHere < listed.length;
  at("loading").hidden = true;
  within(document, ".runs").hidden = listed.length === 0;
  at("no-runs").hidden = listed.length > 0;
  at("previous", HTMLButtonElement).disabled = view.get("after").length === 0;
  at("next", HTMLButtonElement).disabled = next === null;
  showRange();
}

function showRange() {
  const before = PAGE * view.get("after").length;
  const range = `${count(before + 1)} to ${count(before + listed.length)}`;
  const total = totalOf(head.sweep);
  setText(at("range"), listed.length === 0 ? "" : range + (total ? ` of ${total}` : ""));
}

/**
 * How many runs there are under the filter, where the sweep's counts say it; else "".
 *
 * @param {Api.Sweep | null} sweep
 * @returns {string}
 */
function totalOf(sweep) {
  if (sweep === null || view.get("algorithm") || view.get("environment")) return "";
  const status = view.get("status");
  return count(sweep.runs[status === "all" ? "total" : status]);
}

/**
 * A column for each setting in which entries differ; heads that can be sorted by are buttons.
 *
 * @param {string[]} names
 */
function showHeads(names) {
  const row = within(document, ".runs thead tr");
  for (const head of row.querySelectorAll(".setting")) {
    if (!names.includes(head.textContent ?? "")) head.remove();
  }
  const shown = [...row.querySelectorAll(".setting")].map((head) => head.textContent);
  const added = names.filter((name) => !shown.includes(name));
  const last = [...row.querySelectorAll(".setting")].at(-1) ?? at("learner-head");
  last.after(
    ...added.map((name) => {
      const sort = SORTABLE.has(name) ? name : null;
      return element("th", { "scope": "col", "class": "number setting", "data-sort": sort }, name);
    }),
  );
  for (const head of row.querySelectorAll("[data-sort]")) showHead(head);
}

/** @param {Element} head */
function showHead(head) {
  const sort = SORTS.find((each) => each === head.getAttribute("data-sort")) ?? "made";
  if (head.querySelector("button") === null) {
    const button = element("button", { type: "button", class: "sorter" }, head.textContent);
    button.addEventListener("click", () => {
      const isChosen = view.get("sort") === sort;
      view.set({ sort, descending: isChosen ? !view.get("descending") : LARGEST_FIRST.has(sort) });
    });
    head.replaceChildren(button);
  }
  const order = view.get("descending") ? "descending" : "ascending";
  if (view.get("sort") === sort) head.setAttribute("aria-sort", order);
  else head.removeAttribute("aria-sort");
}

/** @param {string[]} after */
function turn(after) {
  view.set({ after });
  at("runs").scrollIntoView();
}

/**
 * Let a filter choose among these names, and the one that it has already.
 *
 * @param {"algorithm" | "environment"} name
 * @param {string[]} names
 */
function offer(name, names) {
  const select = field(form, name, HTMLSelectElement);
  const offered = new Set([...select.options].map((option) => option.value));
  for (const each of new Set([...names, view.get(name)])) {
    if (!offered.has(each)) select.append(element("option", { value: each }, each));
  }
  controls.update();
}

function hideRuns() {
  stream.close();
  at("runs").hidden = true;
}
