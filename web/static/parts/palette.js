/**
 * Colours belong to algorithms, not to order: the palette of Okabe and Ito (2008), told apart by
 * colour-blind eyes, each bound to one algorithm for good. `service/analysis/figures/palette.py` has
 * the same map and shades for the figures in files. Curves of one algorithm are shades of its colour,
 * and differ by their dashes too.
 */

const BLACK = "#000000";
const BLACK_ON_DARK = "#e8e8e8";
const YELLOW = "#f0e442";

const ALGORITHM_COLOURS = new Map([
  ["ddpg", "#0072b2"], // blue
  ["hybrid-ddpg", "#d55e00"], // vermilion
  ["hybrid-ddpg-cosine", "#cc79a7"], // purple
  ["hybrid-ddpg-robust", "#a0623a"], // brown
  ["td3", "#7a5fd0"], // violet
  ["hybrid-td3", "#8a8a00"], // olive
  ["sac", "#56b4e9"], // sky blue
  ["hybrid-sac", "#e69f00"], // orange
  ["gd", "#009e73"], // green
  ["shac", "#1b6e6e"], // teal
  ["ppo", "#808080"], // grey
  ["mpc", BLACK],
]);
const OTHERS = [YELLOW, ...ALGORITHM_COLOURS.values()];

const DASHES = [[], [8, 3.5], [2, 2.5], [8, 3, 2, 3]];
/** The lightness of the first and the last shade, on white and on dark ground. */
const LIGHTNESS = { light: [0.66, 0.28], dark: [0.82, 0.48] };

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
 * Shades of a colour, from light to dark; a single one is the colour itself.
 *
 * @param {string} colour
 * @param {number} count
 * @returns {string[]}
 */
export function shades(colour, count) {
  if (count < 2) return [colour];
  const [hue, , saturation] = hueLightnessSaturation(colour);
  const [first, last] = isDark() ? LIGHTNESS.dark : LIGHTNESS.light;
  return Array.from({ length: count }, (_, i) => {
    return hexOf(hue, first + ((last - first) * i) / (count - 1), saturation);
  });
}

/**
 * The dash pattern (CSS pixels on, off, ...) of the n-th curve of an algorithm.
 *
 * @param {number} variant
 * @returns {number[]}
 */
export function dashPattern(variant) {
  return DASHES[variant % DASHES.length];
}

/**
 * @param {string} colour #rrggbb
 * @returns {[hue: number, lightness: number, saturation: number]} each in [0, 1], as in Python's
 *   colorsys
 */
function hueLightnessSaturation(colour) {
  const [red, green, blue] = [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16) / 255);
  const high = Math.max(red, green, blue);
  const low = Math.min(red, green, blue);
  const lightness = (high + low) / 2;
  const range = high - low;
  if (range === 0) return [0, lightness, 0];
  const saturation = range / (lightness <= 0.5 ? high + low : 2 - high - low);
  const sector =
    high === red ? (green - blue) / range : high === green ? 2 + (blue - red) / range : 4 + (red - green) / range;
  return [(sector / 6 + 1) % 1, lightness, saturation];
}

/**
 * @param {number} hue
 * @param {number} lightness
 * @param {number} saturation
 * @returns {string} #rrggbb
 */
function hexOf(hue, lightness, saturation) {
  const reach = saturation * Math.min(lightness, 1 - lightness);
  const channels = [0, 8, 4].map((offset) => {
    const k = (offset + 12 * hue) % 12;
    const value = lightness - reach * Math.max(-1, Math.min(k - 3, 9 - k, 1));
    return Math.floor(255 * value + 0.5).toString(16).padStart(2, "0");
  });
  return `#${channels.join("")}`;
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
