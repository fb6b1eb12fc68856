/**
 * Lines and bands over one x axis, drawn by uPlot, which only this module and those that it is made
 * of know: layers.js and axes.js.
 */
import { themeColour } from "../parts/palette.js";
import { axis, canvasFont, labelWidth, ticks } from "./axes.js";
import { align, layers, lineIndices } from "./layers.js";
import { withinAxis } from "./y_scale.js";

/**
 * @import { Curve } from "./layers.js"
 * @import { Limits } from "./limits.js"
 * @import { YScale } from "./y_scale.js"
 *
 * @typedef {object} Spec
 * @property {string} group   charts of one group share their cursor
 * @property {(index: number | null) => void} onCursor   the cursor stands on this index of `xs`
 * @property {(from: number | null, to: number | null) => void} [onZoom]   a part of the x axis was
 *   marked by dragging; null twice, by a double click: all of it
 *
 * What uPlot's own types leave out: whether a cursor that is set is told to the group.
 *
 * @typedef {{ setCursor(at: object, fire: boolean, publish: boolean): void }} Publisher
 * @typedef {import("uplot") & Publisher} Publishing
 *
 * @typedef {"linear" | "log" | "symlog"} Scale
 * @typedef {{ value: number, label: string }} Reference
 *
 * @typedef {object} Data
 * @property {Curve[]} curves
 * @property {Reference[]} references   horizontal lines
 * @property {{ label: string, log: boolean, max: number | null, limits: Limits }} x
 * @property {{ label: string, anchors: number[], limits: Limits } & YScale} y   anchors stay in
 *   sight, within the limits
 */

/** @type {Record<Scale, import("uplot").Scale.Distr>} */
const DISTRIBUTIONS = { linear: 1, log: 3, symlog: 4 }; // uPlot's numbers; its 4 is asinh

const DRAG_PIXELS = 8; // less is no part of the axis

/** @type {Data} */
const NOTHING = {
  curves: [],
  references: [],
  x: { label: "", log: false, max: null, limits: [null, null] },
  y: {
    label: "",
    scale: "linear",
    linearWithin: 1,
    floor: -Infinity,
    anchors: [],
    limits: [null, null],
  },
};

export class Chart {
  #container;
  #spec;
  /** @type {import("uplot") | null} */
  #plot = null;
  #structure = "";
  /** @type {Data} */
  #data = NOTHING;
  #resizing;

  /**
   * @param {HTMLElement} container
   * @param {Spec} spec
   */
  constructor(container, spec) {
    this.#container = container;
    this.#spec = spec;
    this.#resizing = new ResizeObserver(() => this.#fit());
    this.#resizing.observe(container);
    this.redraw = this.redraw.bind(this);
    document.addEventListener("themechange", this.redraw);
  }

  /** The x values that cursor indices refer to. */
  get xs() {
    return /** @type {number[]} */ (this.#plot?.data[0] ?? []);
  }

  /** Where the cursor is, as an index of `xs`; null when it is nowhere. */
  get cursorIndex() {
    return this.#plot?.cursor.idx ?? null;
  }

  /** Where the cursor is, in CSS pixels within the container. */
  get cursorLeft() {
    if (this.#plot === null) return 0;
    return (this.#plot.cursor.left ?? 0) + this.#plot.over.offsetLeft;
  }

  /**
   * Show new data; a chart of the same curves keeps its canvas.
   *
   * @param {Data} data
   */
  update(data) {
    this.#data = data;
    const columns = align(data.curves.map((curve) => withinAxis(curve, data.y)));
    const structure = JSON.stringify([
      data.x.label,
      data.x.log,
      data.y.label,
      data.y.scale,
      data.y.linearWithin,
      ...data.curves.map(({ label, colour, low, raw, seeds }) => {
        return [label, colour, !low, !raw, seeds?.length];
      }),
    ]);
    if (this.#plot !== null && structure === this.#structure) {
      this.#plot.setData(columns);
      return;
    }
    this.#plot?.destroy();
    this.#structure = structure;
    this.#plot = new uPlot(this.#options(data), columns, this.#container);
  }

  /**
   * Put the cursor on an index of `xs`, in every chart of the group.
   *
   * @param {number} index
   */
  setCursor(index) {
    const x = this.xs[index];
    const plot = /** @type {Publishing | null} */ (this.#plot);
    plot?.setCursor({ left: x === undefined ? -10 : plot.valToPos(x, "x"), top: 0 }, true, true);
  }

  /** Draw again, in the colours of the theme as it is now. */
  redraw() {
    this.#plot?.redraw(false);
  }

  destroy() {
    this.#resizing.disconnect();
    document.removeEventListener("themechange", this.redraw);
    this.#plot?.destroy();
  }

  #fit() {
    const { width, height } = this.#size();
    if (this.#plot !== null && width > 0) this.#plot.setSize({ width, height });
  }

  #size() {
    return { width: this.#container.clientWidth, height: this.#container.clientHeight };
  }

  /**
   * @param {Data} data
   * @returns {import("uplot").Options}
   */
  #options({ curves, x, y }) {
    return {
      ...this.#size(),
      padding: [10, 12, 0, 0],
      legend: { show: false },
      scales: {
        x: { time: false, distr: x.log ? 3 : 1, range: (_, min, max) => this.#xRange(min, max) },
        y: {
          distr: DISTRIBUTIONS[y.scale],
          asinh: y.linearWithin,
          range: (_, min, max) => this.#yRange(min, max),
        },
      },
      axes: [
        { ...axis(x.label, 26), ...ticks("x", x.log, 64) },
        { ...axis(y.label, labelWidth), ...ticks("y", y.scale !== "linear", 26) },
      ],
      ...layers(curves),
      cursor: cursor(this.#spec, lineIndices(curves)),
      hooks: {
        drawAxes: [(plot) => drawReferences(plot, this.#data.references)],
        setCursor: [
          ({ cursor: { left = -1, idx = null } }) => this.#spec.onCursor(left < 0 ? null : idx),
        ],
        setSelect: [(plot) => this.#zoom(plot)],
      },
    };
  }

  /** @param {import("uplot")} plot */
  #zoom(plot) {
    const { left, width } = plot.select;
    if (width === 0) return;
    const [from, to] = [left, left + width].map((pixel) => plot.posToVal(pixel, "x"));
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.#spec.onZoom?.(Number(from.toPrecision(4)), Number(to.toPrecision(4)));
  }

  /**
   * The range of the x axis, for data within min and max; both are null where there are none.
   *
   * @param {number | null} min
   * @param {number | null} max
   * @returns {[number, number]}
   */
  #xRange(min, max) {
    const [low, high] = this.#wholeXRange(min, max);
    const [from, to] = this.#data.x.limits;
    return [from ?? low, to ?? high];
  }

  /**
   * @param {number | null} min
   * @param {number | null} max
   * @returns {[number, number]}
   */
  #wholeXRange(min, max) {
    const { log, max: end } = this.#data.x;
    if (min === null || max === null) return log ? [1, 10] : [0, end ?? 1];
    if (log) return [min, max > min ? max : min * 10];
    return [0, Math.max(end ?? 0, max) || 1];
  }

  /**
   * @param {number | null} min
   * @param {number | null} max
   * @returns {[number, number]}
   */
  #yRange(min, max) {
    const { anchors, scale, limits } = this.#data.y;
    const [from, to] = limits;
    const lowest = from ?? Math.min(...anchors, min ?? Infinity);
    const highest = to ?? Math.max(...anchors, max ?? -Infinity);
    if (lowest >= highest && (from ?? to) !== null) return [lowest, lowest + 1];
    if (lowest > highest) return [0, 1];
    if (scale === "log") return [lowest / 1.15, highest * 1.15];
    const margin = 0.06 * (highest - lowest || Math.abs(highest) || 1);
    return [lowest - margin, highest + margin];
  }
}

/**
 * @param {Spec} spec
 * @param {Set<number>} lines
 * @returns {import("uplot").Cursor}
 */
function cursor({ group, onZoom }, lines) {
  return {
    y: false,
    move: (plot, left, top) => [left < 0 ? left : nearestStep(plot, left), top],
    drag: { x: onZoom !== undefined, y: false, setScale: false, dist: DRAG_PIXELS },
    bind: {
      dblclick: () => {
        return () => {
          onZoom?.(null, null);
          return null;
        };
      },
    },
    sync: { key: group, scales: ["x", null], filters: { pub: (type) => type === "mousemove" } },
    points: {
      size: 8,
      width: 2,
      stroke: () => themeColour("chart-ground"),
      show: /** @type {import("uplot").Cursor.Points["show"]} */ (
        (/** @type {import("uplot")} */ _, /** @type {number} */ series) =>
          lines.has(series) ? document.createElement("div") : null
      ),
    },
  };
}

/**
 * The cursor jumps from step to step, so that it stands on what it reads.
 *
 * @param {import("uplot")} plot
 * @param {number} left
 * @returns {number}
 */
function nearestStep(plot, left) {
  return plot.data[0].length === 0 ? left : plot.valToPos(plot.data[0][plot.posToIdx(left)], "x");
}

/**
 * Where the random policy and the maximal return lie: hairlines, named at the right edge.
 *
 * @param {import("uplot")} plot
 * @param {Reference[]} references
 */
function drawReferences(plot, references) {
  const { ctx, bbox } = plot;
  const scale = devicePixelRatio;
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = themeColour("chart-reference");
  ctx.lineWidth = scale;
  ctx.font = canvasFont().replace("11px", `${10 * scale}px`);
  ctx.textAlign = "right";
  ctx.textBaseline = "bottom";
  for (const { value, label } of references) {
    const y = Math.round(plot.valToPos(value, "y", true)) + 0.5;
    if (y < bbox.top || y > bbox.top + bbox.height) continue;
    ctx.setLineDash([3 * scale, 3 * scale]);
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
    ctx.fillText(label, bbox.left + bbox.width - 4 * scale, y - 2 * scale);
  }
  ctx.restore();
}
