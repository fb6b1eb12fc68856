/** What a sweep would queue, as the service's dry run says. */
import { element } from "../parts/element.js";
import { count, counted, duration, number } from "../texts/format.js";

/**
 * "3 × 1 × 16 seeds = 48 runs, 960,000 timesteps, about 12 min on 2 workers."
 *
 * @param {Api.Plan} plan
 * @returns {string}
 */
export function estimateText({ timesteps, estimate, product }) {
  const [multiplied] = product.replaceAll(" x ", " × ").split(", about");
  const size = `${multiplied}, ${count(timesteps)} timesteps`;
  if (!estimate || estimate.core_seconds === null) {
    return `${size}. ${estimate?.explanation ?? ""}`.trim();
  }
  const { wall_seconds: wall, core_seconds: core, workers } = estimate;
  const time =
    wall === null ? `${duration(core)} of one core` : `${duration(wall)} on ${counted(workers, "worker")}`;
  return `${size}, about ${time}. ${estimate.explanation ?? ""}`.trim();
}

/**
 * A row per curve and environment: what is left out of the form is the preset's.
 *
 * @param {HTMLTableElement} table
 * @param {Api.Plan} plan
 */
export function fillPlan(table, { cells }) {
  const heads = ["Learner", "Environment", "w1, w2", "Timesteps", "Seeds", "Settings"];
  const rows = cells.map(({ label, environment, weights, timesteps, seeds, config }) => {
    const settings = Object.entries(config).map(([name, value]) => `${name} ${value}`);
    const weightsText = `${number(weights.w1)}, ${number(weights.w2)}`;
    const texts = [label, environment, weightsText, count(timesteps), count(seeds), settings.join(", ")];
    return element("tr", {}, ...texts.map((text) => element("td", {}, text)));
  });
  const head = heads.map((text) => element("th", { scope: "col" }, text));
  table.replaceChildren(
    element("thead", {}, element("tr", {}, ...head)),
    element("tbody", {}, ...rows),
  );
}
