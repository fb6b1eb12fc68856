/** A curve the size of a word: its shape, without axes. */

const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 96;
const HEIGHT = 22;
const MARGIN = 2;

export class Sparkline {
  node = document.createElementNS(SVG, "svg");
  #line = document.createElementNS(SVG, "polyline");
  #drawn = "";

  constructor(colour) {
    this.node.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
    this.node.setAttribute("class", "sparkline");
    this.node.setAttribute("aria-hidden", "true");
    this.#line.setAttribute("stroke", colour);
    this.node.append(this.#line);
  }

  /**
   * @param values (number | null)[], evenly spaced
   * @param share of the width that they fill: how far the run is
   */
  update(values, share) {
    const points = places(values, share).join(" ");
    if (points === this.#drawn) return;
    this.#drawn = points;
    this.#line.setAttribute("points", points);
  }
}

function places(values, share) {
  const finite = values.filter((value) => value !== null);
  const low = Math.min(...finite);
  const span = Math.max(...finite) - low || 1;
  const step = ((WIDTH - 2 * MARGIN) * share) / Math.max(1, values.length - 1);
  return values.flatMap((value, i) => {
    if (value === null) return [];
    const y = HEIGHT - MARGIN - ((HEIGHT - 2 * MARGIN) * (value - low)) / span;
    return [`${(MARGIN + i * step).toFixed(1)},${y.toFixed(1)}`];
  });
}
