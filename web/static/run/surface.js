/** The critic of a one-dimensional task over state and action, beside the truth, as in figure 2. */
import { themeColour } from "../parts/palette.js";
import { number } from "../texts/format.js";

// Five colours of cividis (Nunez and others 2018), which colour-blind eyes read as everybody's.
const COLOURS = [
  [0, 34, 78],
  [65, 77, 107],
  [124, 123, 120],
  [188, 175, 111],
  [254, 232, 56],
];
const TITLE = 20;
const GAP = 16;
const FOOT = 18;

/** @typedef {{ x: number, y: number, width: number, height: number, title: string }} Box */

/** Draws { positions [p], actions [k], value [p][k], truth [p][k], policy [p] }. */
export class Surface {
  #canvas;
  #surface;
  #low;
  #high;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Api.Surface} surface
   */
  constructor(canvas, surface) {
    this.#canvas = canvas;
    this.#surface = surface;
    const all = [...surface.value.flat(), ...surface.truth.flat()];
    this.#low = Math.min(...all);
    this.#high = Math.max(...all);
  }

  /** What the picture shows, in words. */
  get caption() {
    return (
      `The critic’s Q over position (across) and action (up), and the simulated value of the ` +
      `best controller; dark ${number(this.#low)}, bright ${number(this.#high)}. ` +
      "The line is the policy; the ring marks the step that is shown."
    );
  }

  /**
   * Draw both surfaces, and where the episode is.
   *
   * @param {number} position
   * @param {number} action
   */
  draw(position, action) {
    const width = this.#canvas.clientWidth;
    const height = Math.round(0.62 * width);
    const density = devicePixelRatio;
    this.#canvas.width = width * density;
    this.#canvas.height = height * density;
    const context = /** @type {CanvasRenderingContext2D} */ (this.#canvas.getContext("2d"));
    context.scale(density, density);
    const each = (width - 3 * GAP) / 2;
    const { value, truth } = this.#surface;
    const box = { y: TITLE + 8, width: each, height: height - TITLE - FOOT - 16 };
    this.#panel(context, { ...box, x: GAP, title: "critic" }, value, position, action);
    const second = { ...box, x: 2 * GAP + each, title: "truth" };
    this.#panel(context, second, truth, position, action);
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {Box} box
   * @param {number[][]} values
   * @param {number} position
   * @param {number} action
   */
  #panel(context, box, values, position, action) {
    const { positions, actions, policy } = this.#surface;
    const [cellWidth, cellHeight] = [box.width / positions.length, box.height / actions.length];
    values.forEach((column, i) =>
      column.forEach((value, k) => {
        context.fillStyle = this.#colour(value);
        const y = box.y + box.height - (k + 1) * cellHeight;
        context.fillRect(box.x + i * cellWidth, y, cellWidth + 0.6, cellHeight + 0.6);
      }),
    );
    /** @type {(s: number, a: number) => [x: number, y: number]} */
    const place = (s, a) => [
      box.x + box.width * shareOf(s, positions),
      box.y + box.height * (1 - shareOf(a, actions)),
    ];
    context.strokeStyle = "#000000";
    context.lineWidth = 2;
    context.beginPath();
    policy.forEach((a, i) => context.lineTo(...place(positions[i], a)));
    context.stroke();
    context.strokeStyle = "#ffffff";
    context.beginPath();
    context.arc(...place(position, action), 5, 0, 2 * Math.PI);
    context.stroke();
    context.fillStyle = themeColour("chart-text");
    context.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    context.fillText(box.title, box.x, TITLE);
    const range = `${number(positions[0])} m to ${number(positions.at(-1))} m`;
    context.fillText(range, box.x, box.y + box.height + FOOT);
  }

  /**
   * @param {number} value
   * @returns {string}
   */
  #colour(value) {
    const share = (value - this.#low) / (this.#high - this.#low || 1);
    const place = share * (COLOURS.length - 1);
    const i = Math.min(COLOURS.length - 2, Math.floor(place));
    const mixed = COLOURS[i].map((part, c) => part + (place - i) * (COLOURS[i + 1][c] - part));
    return `rgb(${mixed.map(Math.round).join(" ")})`;
  }
}

/**
 * How far along a grid a value lies, of one.
 *
 * @param {number} value
 * @param {number[]} grid
 * @returns {number}
 */
function shareOf(value, grid) {
  const [first] = grid;
  return (value - first) / (grid[grid.length - 1] - first);
}
