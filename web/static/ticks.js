/** Ticks of logarithmic axes: round numbers, as many as there is room for. */

const POWERS = Array.from({ length: 60 }, (_, i) => 10 ** (29 - i));
const ROUND = [1, 5, 2].flatMap((digit) => POWERS.map((power) => digit * power));

/**
 * 0 and +-(1, 5, 2) 10^k within [min, max]; powers of ten first, large ones first.
 *
 * @param position (value) => its place on the axis, in pixels
 * @param spacing pixels between two ticks, at least
 */
export function roundTicks(min, max, position, spacing) {
  const chosen = [];
  for (const value of [...ROUND.flatMap((size) => [size, -size]), 0]) {
    if (value < min || value > max) continue;
    const distances = chosen.map((other) => Math.abs(position(other) - position(value)));
    if (distances.every((distance) => distance >= spacing)) chosen.push(value);
  }
  return chosen.sort((a, b) => a - b);
}
