/** The catalogue: environments with the audit of their derivatives, algorithms with settings. */
import { address, get } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Refresh } from "../connection/refresh.js";
import * as connection from "../connection/state.js";
import { element } from "../parts/element.js";
import { algorithmColour } from "../parts/palette.js";
import { swatch } from "../parts/swatch.js";
import { count, number } from "../texts/format.js";
import { settings } from "../texts/schema.js";

const at = (name) => document.getElementById(name);
const refresh = new Refresh(load, {
  interval: 1000,
  onError: (error) => connection.failed(error),
});
follow(address("/events"), (kind) => kind === "reload" && refresh.request());

async function load(signal) {
  const catalogue = await get("/catalogue", {}, signal);
  fillEnvironments(catalogue.environments);
  at("algorithms").replaceChildren(...catalogue.algorithms.map(algorithmCard));
  at("loading").hidden = true;
  at("body").hidden = false;
  connection.fresh();
}

function fillEnvironments(environments) {
  const heads = [
    ["Environment", ""],
    ["State", "number"],
    ["Action", "number"],
    ["Horizon", "number"],
    ["Largest reward", "number"],
    ["Reward’s gradient", ""],
    ["Kind of step", ""],
    ["States", "number"],
    ["At a kink", "number"],
    ["Worst error", "number"],
    ["Median", "number"],
    ["Audit", ""],
  ].map(([name, kind]) => element("th", { scope: "col", class: kind || null }, name));
  at("environments").replaceChildren(
    element("thead", {}, element("tr", {}, ...heads)),
    ...environments.map(environmentRows),
  );
}

function environmentRows(environment) {
  const audit = environment.audit.length > 0 ? environment.audit : [null];
  const rows = audit.map((found, i) =>
    element("tr", {}, ...(i === 0 ? factCells(environment, audit.length) : []), ...auditCells(found)),
  );
  return element("tbody", {}, ...rows);
}

function factCells(environment, rowspan) {
  const span = String(rowspan);
  const numbers = ["state_size", "action_size", "horizon", "max_reward"].map((name) =>
    element("td", { class: "number", rowspan: span }, number(environment[name])),
  );
  const gradient = environment.reward_is_differentiable ? "yes" : "none: piecewise constant";
  return [
    element("th", { scope: "rowgroup", rowspan: span }, environment.name),
    ...numbers,
    element("td", { rowspan: span }, gradient),
  ];
}

function auditCells(found) {
  if (found === null) {
    return [element("td", { class: "muted", colspan: "6" }, "never audited in this version")];
  }
  const numbers = [count(found.states), count(found.kinks), number(found.worst), number(found.median)];
  const verdict = found.passed ? "passed" : "failed";
  return [
    element("td", {}, found.regime),
    ...numbers.map((text) => element("td", { class: "number" }, text)),
    element("td", { class: found.passed ? null : "failed-audit" }, verdict),
  ];
}

function algorithmCard(algorithm) {
  const identity = { colour: algorithmColour(algorithm.name), dash: [] };
  const notes = [
    algorithm.uses_weights ? "Takes the weights w1 and w2." : "",
    algorithm.needs_reward_gradient ? "Needs the gradient of the reward." : "",
  ];
  return element(
    "article",
    { class: "algorithm" },
    element("h3", {}, swatch(identity), algorithm.name),
    element("p", {}, algorithm.summary),
    element("p", { class: "muted" }, notes.filter(Boolean).join(" ")),
    tableDetails(algorithm, "Settings", ["Setting", "Kind", "Default"], settingRows(algorithm)),
    tableDetails(algorithm, "Presets", ["Environment", "w1, w2", "Timesteps", "Settings"], presetRows(algorithm)),
  );
}

function settingRows({ config_schema: schema }) {
  return settings(schema).map(({ name, kind, initial }) => [name, kind, String(initial ?? "")]);
}

function presetRows({ presets }) {
  return Object.entries(presets).map(([environment, { weights, timesteps, config }]) => [
    environment,
    `${number(weights.w1)}, ${number(weights.w2)}`,
    count(timesteps),
    Object.entries(config)
      .map(([name, value]) => `${name} ${value}`)
      .join(", "),
  ]);
}

function tableDetails({ name }, title, heads, rows) {
  const cells = ([first, ...rest]) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, first),
      ...rest.map((text) => element("td", {}, text)),
    );
  const table = element(
    "table",
    { class: "data" },
    element("thead", {}, element("tr", {}, ...heads.map((text) => element("th", { scope: "col" }, text)))),
    element("tbody", {}, ...rows.map(cells)),
  );
  const scroller = element("div", { "class": "scroller", "role": "region", "tabindex": "0" }, table);
  scroller.setAttribute("aria-label", `${title} of ${name}`);
  return element("details", {}, element("summary", {}, title), scroller);
}
