/** A run's measurements as charts: its returns, then what it diagnosed, the kindred together. */

const GROUPS = [
  ["Return", (name) => ["return_mean", "return_history"].includes(name)],
  ["Direction of the critic’s gradient", (name) => name.includes("cosine")],
  ["Length of the critic’s gradient", (name) => name.includes("ratio")],
  ["Gradient norms", (name) => name.includes("norm") && !name.includes("ratio")],
  ["Losses", (name) => name.includes("loss")],
];
const COSTS = ["timestep", "updates", "jacobians", "seconds", "compile_seconds"];

/** What a diagnostic says, as far as its name does not. */
const MEANINGS = {
  "Return":
    "return_mean: undiscounted return of one evaluation episode; return_history: mean of the latest 100.",
  "Direction of the critic’s gradient":
    "Cosine between the critic’s gradient and the target that the simulator’s derivatives give: 1 is the same direction, 0 at right angles.",
  "Length of the critic’s gradient": "Over that of its target: 1 is the same length.",
  "Gradient norms": "Of the losses in the networks’ parameters, and of the targets.",
  "Losses": "As the updates minimise them, mean since the measurement before.",
};

/** @returns [{ title, caption, names }] of the columns that there are */
export function chartsOf(columns) {
  const names = Object.keys(columns).filter((name) => !COSTS.includes(name));
  const groups = GROUPS.map(([title, belongs]) => ({ title, names: names.filter(belongs) }));
  const grouped = new Set(groups.flatMap((group) => group.names));
  const others = names.filter((name) => !grouped.has(name));
  return [...groups, ...others.map((name) => ({ title: name, names: [name] }))]
    .filter((group) => group.names.length > 0)
    .map((group) => ({ ...group, caption: MEANINGS[group.title] ?? "" }));
}

/** The column of a view's x axis. */
export function abscissa(columns, x) {
  return columns[x === "timesteps" ? "timestep" : x];
}
