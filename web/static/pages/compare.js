/** Two or more sweeps or runs: their curves on one axis, their settings side by side. */
import { saveText, toCsv } from "../curves/curve_table.js";
import { MetricChoice } from "../curves/metric_choice.js";
import { comparisonOf, question } from "../curves/question.js";
import { CurvesSection } from "../curves/section.js";
import { get, refusalOf } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Refresh } from "../connection/refresh.js";
import { offerSharing } from "../connection/sharing.js";
import * as connection from "../connection/state.js";
import { isGuest } from "../parts/caller.js";
import { Controls } from "../parts/controls.js";
import { at, element, keyed, setText } from "../parts/element.js";
import { COMPARISON_FIELDS, flag, list, oneOf, View } from "../parts/view.js";
import { comparedRun, comparedSweep, overlaid, overlaidEntries } from "../compare/compared.js";
import { fillDifferences } from "../compare/differences.js";
import { showScores } from "../compare/scores.js";

const OFFERED = 200;

const view = new View({
  ...COMPARISON_FIELDS,
  sweep: list, // ids
  run: list, // ids
  score: oneOf("final", "return_history", "area"),
  same: flag, // whether settings that agree are shown
});
/** @import { Compared } from "../compare/compared.js" */

const same = at("same", HTMLInputElement);
const offered = at("add", HTMLSelectElement);
const curves = new CurvesSection(view);
const showChosen = keyed(at("chosen"), ({ id }) => id, chip);
const refresh = new Refresh(load, {
  interval: 2000,
  onError: (error) => connection.failed(error),
});
/** @type {Compared[]} */
let compared = [];

if (view.get("run").length > 0) view.set({ band: "none" }); // a single run has none
new Controls(at("controls", HTMLFormElement), view);
new Controls(at("score-controls", HTMLFormElement), view);
const metrics = new MetricChoice(at("controls", HTMLFormElement), view);

follow("", (kind) => {
  if (kind !== "run") refresh.request();
});
if (!isGuest) offerSweeps();
offerSharing(sweepsShown);
view.onChange((fields) => {
  const asked = ["metric", "scale", "x", "band", "seeds", "sweep", "run", "score"];
  if (fields.some((field) => asked.includes(field))) refresh.hurry();
  else draw();
});
document.addEventListener("themechange", draw);
at("download-csv").addEventListener("click", () => {
  saveText(toCsv({ ...comparisonOf(view), panels: overlaid(compared) }), "comparison.csv");
});
same.checked = view.get("same");
same.addEventListener("change", () => view.set({ same: same.checked }));
offered.addEventListener("change", () => {
  view.set({ sweep: [...new Set([...view.get("sweep"), offered.value])] });
  offered.value = "";
});

/** @param {AbortSignal} signal */
async function load(signal) {
  const asked = [
    ...view.get("sweep").map((id) => comparedSweep(id, question(view), signal)),
    ...view.get("run").map((id) => comparedRun(id, question(view), signal)),
  ];
  try {
    compared = await Promise.all(asked);
  } catch (error) {
    setText(at("missing"), refusalOf(error, 404, 422).message);
    at("missing").hidden = false;
    return;
  }
  at("missing").hidden = true;
  draw();
  connection.fresh();
  const names = view.get("sweep").map((id) => get(`/sweeps/${id}/metrics`, {}, signal));
  metrics.offer((await Promise.all(names)).flat());
  await showScores(compared, view, signal);
}

function draw() {
  const isEmpty = compared.length === 0;
  at("curves").hidden = at("settings").hidden = isEmpty;
  showChosen(compared);
  if (isEmpty) return;
  curves.draw(overlaid(compared), overlaidEntries(compared), null);
  const table = at("differences", HTMLTableElement);
  const differing = fillDifferences(table, compared, view.get("same"));
  at("alike").hidden = differing > 0 || compared.length < 2;
}

/**
 * @param {Compared} compared
 * @returns {{ node: HTMLElement, update: () => void }}
 */
function chip({ id, name, page }) {
  const drop = element("button", { type: "button", class: "quiet" }, "Remove");
  drop.setAttribute("aria-label", `Remove ${name}`);
  drop.addEventListener("click", () => {
    const without = (/** @type {string[]} */ ids) => ids.filter((each) => each !== id);
    view.set({ sweep: without(view.get("sweep")), run: without(view.get("run")) });
  });
  return { node: element("li", {}, element("a", { href: page }, name), drop), update: () => {} };
}

/** @returns {string[]} the sweeps that are compared, and those that have the runs */
function sweepsShown() {
  const ofRuns = view.get("run").map((id) => id.split("-")[0]);
  return [...new Set([...view.get("sweep"), ...ofRuns])];
}

async function offerSweeps() {
  try {
    const { items } = await get("/sweeps", { limit: OFFERED });
    offered.append(
      ...items.map((sweep) => element("option", { value: sweep.id }, `${sweep.name} (${sweep.id})`)),
    );
  } catch (error) {
    connection.refused(refusalOf(error));
  }
}
