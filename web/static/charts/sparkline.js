/** A curve the size of a word: its shape, without axes. */
import { shape } from "../parts/element.js";

const WIDTH = 96;
const HEIGHT = 22;
const MARGIN = 2;

export class Sparkline {
  /** @type {SVGSVGElement} */
  node;
  /** @type {SVGPolylineElement} */
  #line;
  #drawn = "";

  /** @param {string} colour */
  constructor(colour) {
    this.#line = shape("polyline", { stroke: colour });
    const viewBox = `0 0 ${WIDTH} ${HEIGHT}`;
    const attributes = { viewBox, "class": "sparkline", "aria-hidden": "true" };
    this.node = shape("svg", attributes, this.#line);
  }

  /**
   * @param {(number | null)[]} values (number | null)[], evenly spaced
   * @param {number} share of the width that they fill: how far the run is
   */
  update(values, share) {
    const points = places(values, share).join(" ");
    if (points === this.#drawn) return;
    this.#drawn = points;
    this.#line.setAttribute("points", points);
  }
}

/**
 * @param {(number | null)[]} values
 * @param {number} share
 * @returns {string[]}
 */
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
