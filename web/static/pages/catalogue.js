/** The catalogue: environments with pictures and audits, algorithms with settings. */
import { get, refusalOf } from "../connection/api.js";
import { follow } from "../connection/live.js";
import { Refresh } from "../connection/refresh.js";
import * as connection from "../connection/state.js";
import { at, element } from "../parts/element.js";
import { algorithmColour } from "../parts/palette.js";
import { prose } from "../parts/prose.js";
import { swatch } from "../parts/swatch.js";
import { still } from "../run/stage.js";
import { count, number } from "../texts/format.js";
import { markdown } from "../texts/markdown.js";
import { settings } from "../texts/schema.js";
import { quantity } from "../texts/task.js";

const PRESET_HEADS = ["Environment", "w1, w2", "Timesteps", "Settings"];
const refresh = new Refresh(load, {
  interval: 1000,
  onError: (error) => connection.failed(error),
});
follow("", (kind) => {
  if (kind === "reload") refresh.request();
});

/** @param {AbortSignal} signal */
async function load(signal) {
  const catalogue = await get("/catalogue", {}, signal);
  const cards = catalogue.environments.map(environmentCard);
  at("pictures").replaceChildren(...cards);
  fillEnvironments(catalogue.environments);
  fillParameters(catalogue);
  at("algorithms").replaceChildren(...catalogue.algorithms.map(algorithmCard));
  at("loading").hidden = true;
  at("body").hidden = false;
  connection.fresh();
  for (const [i, { name }] of catalogue.environments.entries()) {
    cards[i].prepend(await pictureOf(name, signal)); // one after the other: they are drawn so
  }
}

/**
 * A task as it draws itself; where it cannot, why not.
 *
 * @param {string} environment
 * @param {AbortSignal} signal
 * @returns {Promise<HTMLElement>}
 */
async function pictureOf(environment, signal) {
  try {
    const path = /** @type {const} */ (`/environments/${encodeURIComponent(environment)}/picture`);
    return still(await get(path, {}, signal), `${environment} at a start`);
  } catch (error) {
    return element("p", { class: "muted" }, refusalOf(error, 404, 409, 503).message);
  }
}

/**
 * What an environment is: its first paragraphs at once, the rest on demand.
 *
 * @param {Api.Environment} environment
 * @returns {HTMLElement}
 */
function environmentCard({ name, description }) {
  const blocks = markdown(description);
  const end = blocks.findIndex(({ kind }) => kind !== "paragraph");
  const lead = end < 0 ? blocks : blocks.slice(0, end);
  return element(
    "article",
    { class: "card" },
    element("h3", {}, name),
    ...prose(lead),
    proseDetails("Definition", blocks.slice(lead.length)),
  );
}

/**
 * @param {string} title
 * @param {ReturnType<typeof markdown>} blocks
 * @returns {HTMLElement | null} nothing where there are none
 */
function proseDetails(title, blocks) {
  if (blocks.length === 0) return null;
  const text = element("div", { class: "prose" }, ...prose(blocks));
  return element("details", {}, element("summary", {}, title), text);
}

/** @param {Api.Environment[]} environments */
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

/**
 * @param {Api.Environment} environment
 * @returns {HTMLElement}
 */
function environmentRows(environment) {
  const audit = environment.audit.length > 0 ? environment.audit : [null];
  const rows = audit.map((found, i) =>
    element("tr", {}, ...(i === 0 ? factCells(environment, audit.length) : []), ...auditCells(found)),
  );
  return element("tbody", {}, ...rows);
}

/**
 * @param {Api.Environment} environment
 * @param {number} rowspan
 * @returns {HTMLElement[]}
 */
function factCells(environment, rowspan) {
  const span = String(rowspan);
  const { state_size, action_size, horizon, max_reward } = environment;
  const numbers = [state_size, action_size, horizon, max_reward].map((value) =>
    element("td", { class: "number", rowspan: span }, number(value)),
  );
  const gradient = environment.reward_is_differentiable ? "yes" : "none: piecewise constant";
  return [
    element("th", { scope: "rowgroup", rowspan: span }, environment.name),
    ...numbers,
    element("td", { rowspan: span }, gradient),
  ];
}

/**
 * @param {Api.Audit | null} found
 * @returns {HTMLElement[]}
 */
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

/**
 * @param {Api.Schemas["CatalogueAnswer"]} catalogue
 */
function fillParameters({ environments, parameters: common }) {
  const heads = ["Environment", "Parameter", "Default", "Range", "Meaning"].map((name) =>
    element("th", { scope: "col" }, name),
  );
  const own = environments.flatMap(({ name, parameters }) =>
    parameters.map((one) => parameterRow(name, one)),
  );
  at("parameters").replaceChildren(
    element("thead", {}, element("tr", {}, ...heads)),
    element("tbody", {}, ...own, ...common.map((one) => parameterRow("every environment", one))),
  );
}

/**
 * @param {string} environment
 * @param {Api.Environment["parameters"][number]} parameter
 * @returns {HTMLElement}
 */
function parameterRow(environment, parameter) {
  const { name, least, greatest, meaning } = parameter;
  const texts = [
    name,
    quantity(parameter.default, parameter),
    `${number(least)} to ${number(greatest)}`,
    meaning,
  ];
  return element(
    "tr",
    {},
    element("th", { scope: "row" }, environment),
    ...texts.map((text) => element("td", {}, text)),
  );
}

/**
 * @param {Api.Algorithm} algorithm
 * @returns {HTMLElement}
 */
function algorithmCard(algorithm) {
  const identity = { colour: algorithmColour(algorithm.name), dash: [] };
  const notes = [
    algorithm.uses_weights ? "Takes the weights w1 and w2." : "",
    algorithm.needs_reward_gradient ? "Needs the gradient of the reward." : "",
  ];
  return element(
    "article",
    { class: "card" },
    element("h3", {}, swatch(identity), algorithm.name),
    ...prose(markdown(algorithm.summary)),
    element("p", { class: "muted" }, notes.filter(Boolean).join(" ")),
    proseDetails("Definition", markdown(algorithm.description)),
    tableDetails(algorithm, "Settings", ["Setting", "Kind", "Default"], settingRows(algorithm)),
    tableDetails(algorithm, "Presets", PRESET_HEADS, presetRows(algorithm)),
  );
}

/**
 * @param {Api.Algorithm} algorithm
 * @returns {string[][]}
 */
function settingRows({ config_schema: schema }) {
  return settings(schema).map(({ name, kind, initial }) => [name, kind, String(initial ?? "")]);
}

/**
 * @param {Api.Algorithm} algorithm
 * @returns {string[][]}
 */
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

/**
 * @param {Api.Algorithm} algorithm
 * @param {string} title
 * @param {string[]} heads
 * @param {string[][]} rows
 * @returns {HTMLElement}
 */
function tableDetails({ name }, title, heads, rows) {
  const cells = (/** @type {string[]} */ [first, ...rest]) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, first),
      ...rest.map((text) => element("td", {}, text)),
    );
  const columns = heads.map((text) => element("th", { scope: "col" }, text));
  const table = element(
    "table",
    { class: "data" },
    element("thead", {}, element("tr", {}, ...columns)),
    element("tbody", {}, ...rows.map(cells)),
  );
  const scroller = element("div", { "class": "scroller", "role": "region", "tabindex": "0" }, table);
  scroller.setAttribute("aria-label", `${title} of ${name}`);
  return element("details", {}, element("summary", {}, title), scroller);
}
