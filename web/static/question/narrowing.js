/** A confidence sequence as it narrows: the band of the mean over the pairs seen. */
import { element, shape } from "../parts/element.js";

const WIDTH = 300;
const HEIGHT = 90;
const APART = 0.15; // share of the height between two numbers that can be read

/** @typedef {{ least: number, most: number }} Extent of the differences that are drawn */

/**
 * The extent of some sequences: drawn to one scale, they can be compared.
 *
 * @param {Api.Comparison["sequence"][]} sequences
 * @param {number} margin
 * @returns {Extent}
 */
export function extentOf(sequences, margin) {
  const known = (/** @type {(number | null)[]} */ values) => values.filter((value) => value !== null);
  return {
    least: Math.min(-margin, ...sequences.flatMap(({ low }) => known(low))),
    most: Math.max(margin, ...sequences.flatMap(({ high }) => known(high))),
  };
}

/**
 * @param {Api.Comparison["sequence"]} sequence
 * @param {number} margin differences of less than that do not matter
 * @param {string} colour
 * @param {Extent} extent
 * @returns {HTMLElement}
 */
export function narrowing(sequence, margin, colour, extent) {
  const looks = looksOf(sequence);
  const ends = looks.length > 1 ? [`${looks[0].pairs}`, `${looks.at(-1)?.pairs} pairs`] : [];
  return element(
    "div",
    { class: "narrowing" },
    element("div", { "class": "scale", "aria-hidden": "true" }, ...marks(extent)),
    picture(looks, margin, colour, extent),
    element("div", { "class": "pairs", "aria-hidden": "true" }, ...ends.map((text) => element("span", {}, text))),
  );
}

/**
 * @param {Api.Comparison["sequence"]} sequence
 * @returns {Look[]}
 */
function looksOf({ n, mean, low, high }) {
  return n.flatMap((pairs, i) => {
    const [middle, bottom, top] = [mean[i], low[i], high[i]];
    return middle === null || bottom === null || top === null ? [] : [{ pairs, middle, bottom, top }];
  });
}

/**
 * 0 and the ends of the scale, each at its height; an end that is too near to 0 is left out.
 *
 * @param {Extent} extent
 * @returns {HTMLElement[]}
 */
function marks({ least, most }) {
  const height = (/** @type {number} */ value) => (most - value) / (most - least);
  const ends = [most, least].filter((value) => Math.abs(height(value) - height(0)) > APART);
  return [0, ...ends].map((value) => {
    const mark = element("span", {}, value === 0 ? "0" : signed(value));
    mark.style.top = `${100 * within(height(value))}%`;
    return mark;
  });
}

/**
 * @param {number} value
 * @returns {string}
 */
function signed(value) {
  return `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(2)}`;
}

/**
 * A share of the extent as one of the drawing, which keeps a little room above and below.
 *
 * @param {number} share
 * @returns {number}
 */
function within(share) {
  return 0.04 + 0.92 * share;
}

/**
 * @param {Look[]} seen
 * @param {number} margin
 * @param {string} colour
 * @param {Extent} extent
 * @returns {SVGSVGElement}
 */
function picture(seen, margin, colour, { least, most }) {
  const drawing = shape("svg", {
    "viewBox": `0 0 ${WIDTH} ${HEIGHT}`,
    "preserveAspectRatio": "none",
    "role": "img",
    "aria-label": description(seen),
  });
  const first = seen[0]?.pairs ?? 0;
  const last = seen.at(-1)?.pairs ?? 1;
  const x = (/** @type {number} */ pairs) =>
    seen.length > 1 ? (WIDTH * (pairs - first)) / (last - first) : WIDTH / 2;
  const y = (/** @type {number} */ value) => HEIGHT * within((most - value) / (most - least));
  drawing.append(
    shape("rect", {
      class: "margin",
      x: 0,
      y: y(margin),
      width: WIDTH,
      height: y(-margin) - y(margin),
    }),
    shape("line", { class: "zero", x1: 0, x2: WIDTH, y1: y(0), y2: y(0) }),
    ...drawn(seen, x, y, colour),
  );
  return drawing;
}

/**
 * @typedef {{ pairs: number, middle: number, bottom: number, top: number }} Look
 * @typedef {(value: number) => number} Scale
 */

/**
 * The band and the mean; bars where there is one look only.
 *
 * @param {Look[]} seen
 * @param {Scale} x
 * @param {Scale} y
 * @param {string} colour
 * @returns {SVGElement[]}
 */
function drawn(seen, x, y, colour) {
  if (seen.length === 1) {
    const [{ pairs, middle, bottom, top }] = seen;
    const place = { x1: x(pairs), x2: x(pairs), stroke: colour };
    return [
      shape("line", { class: "mean", ...place, y1: y(bottom), y2: y(top) }),
      shape("line", { class: "dot", ...place, y1: y(middle), y2: y(middle) }),
    ];
  }
  const upper = seen.map(({ pairs, top }) => `${x(pairs)},${y(top)}`);
  const lower = seen.map(({ pairs, bottom }) => `${x(pairs)},${y(bottom)}`).toReversed();
  const middle = seen.map(({ pairs, middle: value }) => `${x(pairs)},${y(value)}`);
  return [
    shape("polygon", { class: "band", points: [...upper, ...lower].join(" "), fill: colour }),
    shape("polyline", { class: "mean", points: middle.join(" "), stroke: colour }),
  ];
}

/**
 * @param {Look[]} seen
 * @returns {string}
 */
function description(seen) {
  const parts = seen.map(
    ({ pairs, bottom, top }) => `${pairs} pairs: ${bottom.toFixed(3)} to ${top.toFixed(3)}`,
  );
  return parts.length > 0 ? `The interval as it narrows. ${parts.join("; ")}` : "No pair yet";
}
