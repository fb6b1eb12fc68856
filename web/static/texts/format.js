/** How numbers, durations and moments read: one place, so that the whole dashboard agrees. */

const significant = new Intl.NumberFormat("en", { maximumSignificantDigits: 4 });
const short = new Intl.NumberFormat("en", { maximumSignificantDigits: 3 });
const whole = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });
const compact = new Intl.NumberFormat("en", { notation: "compact", maximumSignificantDigits: 4 });
const scientific = new Intl.NumberFormat("en", {
  notation: "scientific",
  maximumSignificantDigits: 3,
});
const clock = new Intl.DateTimeFormat("en-GB", { timeStyle: "medium" });
const calendar = new Intl.DateTimeFormat("en-GB", { dateStyle: "medium", timeStyle: "short" });

/**
 * A typographic minus: as wide as a plus, and never broken off its number.
 *
 * @param {string} text
 * @returns {string}
 */
function withMinus(text) {
  return text.replace(/-/g, "−");
}

/**
 * Four significant digits; a dash where there is no value.
 *
 * @param {number | null | undefined} value
 * @returns {string}
 */
export function number(value) {
  if (value === null || value === undefined) return "–";
  const magnitude = Math.abs(value);
  const extreme = magnitude !== 0 && (magnitude < 1e-4 || magnitude >= 1e7);
  return withMinus((extreme ? scientific : significant).format(value));
}

/**
 * "0.842 ± 0.031" where the band is symmetric, else "0.842 (0.8 to 0.9)"; three digits.
 *
 * @param {number | null} mean
 * @param {number | null} low
 * @param {number | null} high
 * @returns {string}
 */
export function withBand(mean, low, high) {
  if (mean === null) return "–";
  const text = withMinus(short.format(mean));
  if (low === null || high === null) return text;
  const half = (high - low) / 2;
  const isSymmetric = Math.abs(high + low - 2 * mean) <= 1e-6 * Math.max(Math.abs(mean), half);
  if (isSymmetric) return `${text} ± ${short.format(half)}`;
  return `${text} (${withMinus(`${short.format(low)} to ${short.format(high)}`)})`;
}

/**
 * A count, with thousands set apart.
 *
 * @param {number} value
 * @returns {string}
 */
export function count(value) {
  return whole.format(value);
}

/**
 * "1 run", "12 runs".
 *
 * @param {number} value
 * @param {string} noun
 * @returns {string}
 */
export function counted(value, noun) {
  return `${count(value)} ${noun}${value === 1 ? "" : "s"}`;
}

/**
 * An axis label: 20000 reads "20k", -1500 reads "−1.5k".
 *
 * @param {number} value
 * @returns {string}
 */
export function tick(value) {
  const magnitude = Math.abs(value);
  if (magnitude !== 0 && (magnitude < 1e-3 || magnitude >= 1e12)) {
    return withMinus(scientific.format(value));
  }
  if (magnitude < 1000) return withMinus(significant.format(value));
  return withMinus(compact.format(value).replace("K", "k"));
}

/**
 * A share of one, never rounded up to a false "100 %".
 *
 * @param {number} share
 * @returns {string}
 */
export function percent(share) {
  return `${Math.floor(share * 100 + 1e-9)} %`;
}

/**
 * Seconds in the two units that matter: "42 s", "3 min 20 s", "1 h 5 min", "2 d 3 h".
 *
 * @param {number} seconds
 * @returns {string}
 */
export function duration(seconds) {
  const total = Math.max(0, Math.round(seconds));
  /** @type {[value: number, unit: string][]} */
  const parts = [
    [Math.floor(total / 86400), "d"],
    [Math.floor(total / 3600) % 24, "h"],
    [Math.floor(total / 60) % 60, "min"],
    [total % 60, "s"],
  ];
  const first = parts.findIndex(([value]) => value > 0);
  if (first < 0) return "0 s";
  return parts
    .slice(first, first + 2)
    .filter(([value]) => value > 0)
    .map(([value, unit]) => `${value} ${unit}`)
    .join(" ");
}

/**
 * How long until a sweep ends, as coarse as the estimate is.
 *
 * @param {number | null | undefined} seconds
 * @returns {string}
 */
export function remaining(seconds) {
  if (seconds === null || seconds === undefined) return "";
  if (seconds < 10) return "a few seconds left";
  const step = seconds < 120 ? 10 : seconds < 7200 ? 60 : 600;
  return `about ${duration(Math.round(seconds / step) * step)} left`;
}

/**
 * How long ago, as people say it.
 *
 * @param {Date} date
 * @param {Date} [now]
 * @returns {string}
 */
export function ago(date, now = new Date()) {
  const seconds = Math.max(0, (now.getTime() - date.getTime()) / 1000);
  if (seconds < 10) return "just now";
  const step = seconds < 60 ? 10 : seconds < 3600 ? 60 : seconds < 86400 ? 3600 : 86400;
  return `${duration(Math.floor(seconds / step) * step)} ago`;
}

/**
 * @param {Date} date
 * @returns {string}
 */
export function timeOfDay(date) {
  return clock.format(date);
}

/**
 * @param {Date} date
 * @returns {string}
 */
export function dateAndTime(date) {
  return calendar.format(date);
}

/**
 * The seconds from one moment to another, as the service names them.
 *
 * @param {string} start
 * @param {string} end
 * @returns {number}
 */
export function secondsBetween(start, end) {
  return (Date.parse(end) - Date.parse(start)) / 1000;
}
