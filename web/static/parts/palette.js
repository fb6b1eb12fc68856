/**
 * Colours belong to algorithms, not to order: the palette of Okabe and Ito (2008), told apart by
 * colour-blind eyes, each bound to one algorithm for good. `service/analysis/figures/palette.py` has
 * the same map for the figures in files. Curves of one colour differ by their dashes.
 */

const BLACK = "#000000";
const BLACK_ON_DARK = "#e8e8e8";
const YELLOW = "#f0e442";

const ALGORITHM_COLOURS = new Map([
  ["ddpg", "#0072b2"], // blue
  ["hybrid-ddpg", "#d55e00"], // vermilion
  ["hybrid-ddpg-cosine", "#cc79a7"], // purple
  ["sac", "#56b4e9"], // sky blue
  ["hybrid-sac", "#e69f00"], // orange
  ["gd", "#009e73"], // green
  ["mpc", BLACK],
]);
const OTHERS = [YELLOW, ...ALGORITHM_COLOURS.values()];

const DASHES = [[], [8, 3.5], [2, 2.5]];

/**
 * An algorithm's colour; one that another package brought gets one by its name.
 *
 * @param {string} algorithm
 * @returns {string}
 */
export function algorithmColour(algorithm) {
  const colour = ALGORITHM_COLOURS.get(algorithm) ?? OTHERS[crc32(algorithm) % OTHERS.length];
  return colour === BLACK && isDark() ? BLACK_ON_DARK : colour;
}

/**
 * The dash pattern (CSS pixels on, off, ...) of the n-th curve of a colour: at last dots in dashes.
 *
 * @param {number} variant
 * @returns {number[]}
 */
export function dashPattern(variant) {
  return DASHES[variant] ?? [8, 3, ...Array.from({ length: variant - 2 }, () => [2, 3]).flat()];
}

/**
 * A colour thinned for areas, and for lines that stay in the background.
 *
 * @param {string} colour
 * @param {number} opacity
 * @returns {string}
 */
export function faint(colour, opacity) {
  return colour + Math.round(opacity * 255).toString(16).padStart(2, "0");
}

/**
 * The theme's own colours, for canvases: custom properties registered as colours in tokens.css.
 *
 * @param {string} name
 * @returns {string}
 */
export function themeColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`);
}

/** @returns {boolean} */
function isDark() {
  const chosen = document.documentElement.dataset.theme;
  if (chosen === "light" || chosen === "dark") return chosen === "dark";
  return matchMedia("(prefers-color-scheme: dark)").matches;
}

/**
 * CRC-32 as in zlib.
 *
 * @param {string} text
 * @returns {number}
 */
export function crc32(text) {
  let crc = ~0;
  for (const byte of new TextEncoder().encode(text)) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}
