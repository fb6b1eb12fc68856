/** A confidence sequence as it narrows: the band of the mean over the pairs seen. */
import { shape } from "../parts/element.js";

const WIDTH = 300;
const HEIGHT = 90;

/**
 * @param {Api.Comparison["sequence"]} sequence
 * @param {number} margin differences of less than that do not matter
 * @param {string} colour
 * @returns {SVGSVGElement}
 */
export function narrowing({ n, mean, low, high }, margin, colour) {
  const seen = n.flatMap((pairs, i) => {
    const [middle, bottom, top] = [mean[i], low[i], high[i]];
    return middle === null || bottom === null || top === null ? [] : [{ pairs, middle, bottom, top }];
  });
  const picture = shape("svg", {
    "viewBox": `0 0 ${WIDTH} ${HEIGHT}`,
    "preserveAspectRatio": "none",
    "class": "narrowing",
    "role": "img",
    "aria-label": description(seen),
  });
  const least = Math.min(-margin, ...seen.map(({ bottom }) => bottom));
  const most = Math.max(margin, ...seen.map(({ top }) => top));
  const first = seen[0]?.pairs ?? 0;
  const last = seen.at(-1)?.pairs ?? 1;
  const x = (/** @type {number} */ pairs) =>
    seen.length > 1 ? (WIDTH * (pairs - first)) / (last - first) : WIDTH / 2;
  const y = (/** @type {number} */ value) => HEIGHT * (0.04 + (0.92 * (most - value)) / (most - least));
  picture.append(
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
  return picture;
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
    const [{ pairs, bottom, top }] = seen;
    const bar = { x1: x(pairs), x2: x(pairs), y1: y(bottom), y2: y(top), stroke: colour };
    return [shape("line", { class: "mean", ...bar })];
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
