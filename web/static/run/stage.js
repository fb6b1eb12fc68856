/** A task drawn on a canvas from its film: metres, y up, shapes in the order of painting. */
import { element } from "../parts/element.js";
import { faint, themeColour } from "../parts/palette.js";

/**
 * An episode's film, and its contacts, [x, y, px, py] each, of every step (m, N s).
 *
 * styles  [{ shape: "capsule" | "polygon", role, radius }]
 * frames  a frame per state: [[style, x, y, x, y, ...], ...]
 * views   (left, bottom, right, top) of each frame, or a single one for all
 *
 * @typedef {Pick<Api.Episode, "styles" | "frames" | "views" | "contacts">} Film
 *
 * What is drawn with a frame.
 *
 * @typedef {object} Extras
 * @property {number[][]} trail        [x, y] each: a line behind the shapes
 * @property {number[]} ghosts         frames of which the body is shown faintly
 * @property {number[][]} faintArrows  impulses of earlier steps
 * @property {number[][]} arrows       impulses of this one
 */

/** @type {Extras} */
const NOTHING_BESIDE = { trail: [], ghosts: [], faintArrows: [], arrows: [] };
const LONGEST_ARROW = 0.6; // of the view's height
const HEAD_PIXELS = 8;
const GHOST_OPACITY = 0.18;
const PAST_OPACITY = 0.35; // of arrows
const HIGHEST = 0.7; // of the width

export class Stage {
  #canvas;
  #film;
  #longest;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Film} film
   */
  constructor(canvas, film) {
    this.#canvas = canvas;
    this.#film = film;
    this.#longest = Math.max(...film.contacts.flat().map(([, , px, py]) => Math.hypot(px, py)));
  }

  /**
   * @param {number} step which frame
   * @param {Extras} extras
   */
  draw(step, { trail, ghosts, faintArrows, arrows }) {
    const { frames, views } = this.#film;
    const view = views.length === 1 ? views[0] : views[step];
    const pen = new Pen(this.#canvas, view);
    for (const ghost of ghosts) this.#paint(pen, frames[ghost], ["body"], GHOST_OPACITY);
    pen.line(trail, themeColour("stage-trail"));
    this.#paint(pen, frames[step], null, 1);
    const metres = (LONGEST_ARROW * (view[3] - view[1])) / this.#longest;
    const red = hex(themeColour("stage-impulse"));
    for (const [x, y, px, py] of faintArrows) {
      pen.arrow(x, y, metres * px, metres * py, faint(red, PAST_OPACITY));
    }
    for (const [x, y, px, py] of arrows) pen.arrow(x, y, metres * px, metres * py, red);
  }

  /**
   * Paint the shapes of some roles, null for all.
   *
   * @param {Pen} pen
   * @param {number[][]} frame
   * @param {string[] | null} roles
   * @param {number} opacity
   */
  #paint(pen, frame, roles, opacity) {
    for (const [number, ...points] of frame) {
      const { shape, role, radius } = this.#film.styles[number];
      if (roles !== null && !roles.includes(role)) continue;
      const colour = faint(hex(themeColour(`stage-${role}`)), opacity);
      if (shape === "capsule") pen.capsule(points, radius, colour);
      else pen.polygon(points, colour);
    }
  }
}

/**
 * A picture of a single state, drawn again in another theme or width.
 *
 * @param {Omit<Film, "contacts">} picture
 * @param {string} label
 * @returns {HTMLCanvasElement}
 */
export function still(picture, label) {
  const canvas = element("canvas", { "class": "stage", "role": "img", "aria-label": label });
  const stage = new Stage(canvas, { ...picture, contacts: [] });
  const draw = () => {
    if (canvas.clientWidth > 0) stage.draw(0, NOTHING_BESIDE);
  };
  new ResizeObserver(draw).observe(canvas);
  document.addEventListener("themechange", draw);
  return canvas;
}

/** Draws in metres. */
class Pen {
  #context;
  #x;
  #y;
  #scale;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {number[]} view
   */
  constructor(canvas, [left, bottom, right, top]) {
    const width = canvas.clientWidth;
    const height = Math.round(width * Math.min(HIGHEST, (top - bottom) / (right - left)));
    const density = devicePixelRatio;
    canvas.width = width * density;
    canvas.height = height * density;
    this.#scale = Math.min(width / (right - left), height / (top - bottom));
    const margin = (width - this.#scale * (right - left)) / 2;
    this.#x = (/** @type {number} */ x) => margin + this.#scale * (x - left);
    this.#y = (/** @type {number} */ y) => this.#scale * (top - y);
    this.#context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    this.#context.scale(density, density);
  }

  /**
   * @param {number[]} ends
   * @param {number} radius
   * @param {string} colour
   */
  capsule([x1, y1, x2, y2], radius, colour) {
    const context = this.#context;
    context.strokeStyle = context.fillStyle = colour;
    context.beginPath();
    if (x1 === x2 && y1 === y2) {
      context.arc(this.#x(x1), this.#y(y1), Math.max(1, this.#scale * radius), 0, 2 * Math.PI);
      context.fill();
      return;
    }
    context.lineCap = "round";
    context.lineWidth = Math.max(1, 2 * this.#scale * radius);
    context.moveTo(this.#x(x1), this.#y(y1));
    context.lineTo(this.#x(x2), this.#y(y2));
    context.stroke();
  }

  /**
   * @param {number[]} points
   * @param {string} colour
   */
  polygon(points, colour) {
    const context = this.#context;
    context.fillStyle = colour;
    context.beginPath();
    for (let i = 0; i < points.length; i += 2) {
      context.lineTo(this.#x(points[i]), this.#y(points[i + 1]));
    }
    context.closePath();
    context.fill();
  }

  /**
   * @param {number[][]} points
   * @param {string} colour
   */
  line(points, colour) {
    const context = this.#context;
    context.strokeStyle = colour;
    context.lineWidth = 1.5;
    context.setLineDash([5, 4]);
    context.beginPath();
    for (const [x, y] of points) context.lineTo(this.#x(x), this.#y(y));
    context.stroke();
    context.setLineDash([]);
  }

  /**
   * An arrow from a point, the head at its end and no longer than it.
   *
   * @param {number} x
   * @param {number} y
   * @param {number} dx
   * @param {number} dy
   * @param {string} colour
   */
  arrow(x, y, dx, dy, colour) {
    const context = this.#context;
    const [fromX, fromY, toX, toY] = [this.#x(x), this.#y(y), this.#x(x + dx), this.#y(y + dy)];
    const length = Math.hypot(toX - fromX, toY - fromY);
    const head = Math.min(HEAD_PIXELS, length / 2);
    context.save();
    context.translate(fromX, fromY);
    context.rotate(Math.atan2(toY - fromY, toX - fromX));
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = 3;
    context.lineCap = "butt";
    context.beginPath();
    context.moveTo(0, 0);
    context.lineTo(length - head, 0);
    context.stroke();
    context.beginPath();
    context.moveTo(length, 0);
    context.lineTo(length - 1.5 * head, 0.75 * head);
    context.lineTo(length - 1.5 * head, -0.75 * head);
    context.fill();
    context.restore();
  }
}

/**
 * "rgb(1, 2, 3)", as browsers give registered colours back, as "#010203".
 *
 * @param {string} colour
 * @returns {string}
 */
function hex(colour) {
  const parts = colour.match(/[\d.]+/g);
  if (!colour.startsWith("rgb") || parts === null) return colour.trim();
  const hexed = parts.slice(0, 3).map((part) => Math.round(Number(part)).toString(16));
  return `#${hexed.map((digits) => digits.padStart(2, "0")).join("")}`;
}
