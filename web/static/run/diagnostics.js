/** A run's measurements as charts: its returns, then what it diagnosed, the kindred together. */

/** @typedef {{ title: string, caption: string, names: string[] }} ChartOf   columns in one chart */
/** @typedef {Record<string, (number | null)[]>} Columns   a run's measurements by name */

/** @type {[title: string, belongs: (name: string) => boolean][]} */
const GROUPS = [
  ["Return", (name) => ["return_mean", "return_history"].includes(name)],
  ["Direction of the critic’s gradient", (name) => name.includes("cosine")],
  ["Length of the critic’s gradient", (name) => name.includes("ratio")],
  ["Gradient norms", (name) => name.includes("norm") && !name.includes("ratio")],
  ["Losses", (name) => name.includes("loss")],
];
const COSTS = ["timestep", "updates", "jacobians", "seconds", "compile_seconds"];

/** What a diagnostic says, as far as its name does not. */
const MEANINGS = new Map([
  [
    "Return",
    "return_mean: undiscounted return of one evaluation episode; return_history: mean of the " +
      "latest 100.",
  ],
  [
    "Direction of the critic’s gradient",
    "Cosine between the critic’s gradient and the target that the simulator’s derivatives give: 1 " +
      "is the same direction, 0 at right angles.",
  ],
  ["Length of the critic’s gradient", "Over that of its target: 1 is the same length."],
  ["Gradient norms", "Of the losses in the networks’ parameters, and of the targets."],
  ["Losses", "As the updates minimise them, mean since the measurement before."],
]);

/**
 * The charts of the columns that there are.
 *
 * @param {Columns} columns
 * @returns {ChartOf[]}
 */
export function chartsOf(columns) {
  const names = Object.keys(columns).filter((name) => !COSTS.includes(name));
  const groups = GROUPS.map(([title, belongs]) => ({ title, names: names.filter(belongs) }));
  const grouped = new Set(groups.flatMap((group) => group.names));
  const others = names.filter((name) => !grouped.has(name));
  return [...groups, ...others.map((name) => ({ title: name, names: [name] }))]
    .filter((group) => group.names.length > 0)
    .map((group) => ({ ...group, caption: MEANINGS.get(group.title) ?? "" }));
}

/**
 * The column of a view's x axis.
 *
 * @param {Columns} columns
 * @param {string} x
 * @returns {number[]}
 */
export function abscissa(columns, x) {
  return /** @type {number[]} */ (columns[x === "timesteps" ? "timestep" : x]); // of no gaps
}
