/** Curves that were measured at different steps, on one x axis. */

/** All steps of some grids, each once, increasing; the grids' own array where they are equal. */
export function union(grids) {
  const first = grids[0] ?? [];
  if (grids.every((grid) => isSame(grid, first))) return first;
  return [...new Set(grids.flat())].sort((a, b) => a - b);
}

function isSame(a, b) {
  return a === b || (a.length === b.length && a.every((x, i) => x === b[i]));
}

/** Puts a curve's values on the union `xs` of steps; where it has none the line passes through. */
export function placement(x, xs) {
  if (isSame(x, xs)) return (values) => values;
  const index = new Map(xs.map((value, i) => [value, i]));
  const places = x.map((value) => index.get(value));
  return (values) => {
    const column = new Array(xs.length); // undefined, which uPlot spans; null it keeps as a gap
    places.forEach((place, i) => (column[place] = values[i]));
    return column;
  };
}
