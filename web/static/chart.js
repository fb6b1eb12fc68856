/**
 * Lines and bands over one x axis, drawn by uPlot. The only module that knows uPlot: a chart is
 * made by `create(container, spec)`, shown by `update(data)` and taken down by `destroy()`.
 *
 * @typedef {object} Spec
 * @property {string} group   charts of one group share their cursor
 * @property {(index: number | null) => void} onCursor   the cursor stands on this index of `xs`
 *
 * @typedef {object} Curve
 * @property {string} label, colour
 * @property {number[]} dash
 * @property {number[]} x
 * @property {(number|null)[]} line    what is drawn boldly
 * @property {(number|null)[]} [low], [high]   the band, absent when none is shown
 * @property {(number|null)[]} [raw]   drawn faintly behind a smoothed line
 * @property {(number|null)[][]} [seeds]   thin single lines
 *
 * @typedef {object} Data
 * @property {Curve[]} curves
 * @property {{value: number, label: string}[]} references   horizontal lines
 * @property {{label: string, log: boolean, max: number | null}} x
 * @property {{label: string, scale: "linear" | "log" | "symlog", linearWithin: number,
 *   anchors: number[]}} y   anchors stay in sight; symlog is linear in [-linearWithin, linearWithin]
 */
import { placement, union } from "./alignment.js";
import { tick } from "./format.js";
import { faint, themeColour } from "./palette.js";
import { roundTicks } from "./ticks.js";

const BAND_OPACITY = 0.16;
const FAINT_OPACITY = 0.35;
const SEED_OPACITY = 0.3;
const LINE_WIDTH = 2;
const DISTRIBUTIONS = { linear: 1, log: 3, symlog: 4 }; // uPlot's numbers; its 4 is asinh

export function create(container, spec) {
  return new Chart(container, spec);
}

class Chart {
  #container;
  #spec;
  #plot = null;
  #structure = "";
  #data = null;
  #resizing;

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
    return this.#plot?.data[0] ?? [];
  }

  /** Where the cursor is, as an index of `xs`; null when it is nowhere. */
  get cursorIndex() {
    return this.#plot?.cursor.idx ?? null;
  }

  /** Where the cursor is, in CSS pixels within the container. */
  get cursorLeft() {
    return this.#plot.cursor.left + this.#plot.over.offsetLeft;
  }

  /** Show new data; a chart of the same curves keeps its canvas. */
  update(data) {
    this.#data = data;
    const columns = align(data.curves);
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
    this.#plot = new globalThis.uPlot(this.#options(), columns, this.#container);
  }

  /** Put the cursor on an index of `xs`, in every chart of the group. */
  setCursor(index) {
    const x = this.xs[index];
    const left = x === undefined ? -10 : this.#plot.valToPos(x, "x");
    this.#plot.setCursor({ left, top: 0 }, true, true);
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

  #options() {
    const data = this.#data;
    return {
      ...this.#size(),
      padding: [10, 12, 0, 0],
      legend: { show: false },
      scales: {
        x: { time: false, distr: data.x.log ? 3 : 1, range: (_, min, max) => this.#xRange(min, max) },
        y: {
          distr: DISTRIBUTIONS[data.y.scale],
          asinh: data.y.linearWithin,
          range: (_, min, max) => this.#yRange(min, max),
        },
      },
      axes: [
        { ...axis(data.x.label, 26), ...ticks("x", data.x.log, 64) },
        { ...axis(data.y.label, labelWidth), ...ticks("y", data.y.scale !== "linear", 26) },
      ],
      ...layers(data.curves),
      cursor: cursor(this.#spec.group, lineIndices(data.curves)),
      hooks: {
        drawAxes: [(plot) => drawReferences(plot, this.#data.references)],
        setCursor: [(plot) => this.#spec.onCursor(plot.cursor.left < 0 ? null : plot.cursor.idx)],
      },
    };
  }

  #xRange(min, max) {
    const { log, max: end } = this.#data.x;
    if (min === null) return log ? [1, 10] : [0, end ?? 1];
    if (log) return [min, max > min ? max : min * 10];
    return [0, Math.max(end ?? 0, max) || 1];
  }

  #yRange(min, max) {
    const { anchors } = this.#data.y;
    const lowest = Math.min(...anchors, min ?? Infinity);
    const highest = Math.max(...anchors, max ?? -Infinity);
    if (lowest > highest) return [0, 1];
    if (this.#data.y.scale === "log") return [lowest / 1.15, highest * 1.15];
    const margin = 0.06 * (highest - lowest || Math.abs(highest) || 1);
    return [lowest - margin, highest + margin];
  }
}

/** uPlot's columns [x, ...series], in the order of `layers`, on the union of the curves' steps. */
function align(curves) {
  const xs = union(curves.map((curve) => curve.x));
  const onto = curves.map((curve) => placement(curve.x, xs));
  const each = (pick) => curves.flatMap((curve, i) => pick(curve).map((column) => onto[i](column)));
  return [xs, ...LAYERS.flatMap(({ columns }) => each(columns))];
}

/** What is drawn, back to front: each layer takes some columns of every curve. */
const LAYERS = [
  {
    columns: (curve) => (curve.low ? [curve.high, curve.low] : []),
    style: () => ({ points: { show: false } }),
  },
  {
    columns: (curve) => curve.seeds ?? [],
    style: ({ colour }) => ({ stroke: faint(colour, SEED_OPACITY), width: 1, ...noPoints }),
  },
  {
    columns: (curve) => (curve.raw ? [curve.raw] : []),
    style: ({ colour }) => ({ stroke: faint(colour, FAINT_OPACITY), width: 1, ...noPoints }),
  },
  {
    columns: (curve) => [curve.line],
    style: ({ colour, dash }) => ({
      stroke: colour,
      width: LINE_WIDTH,
      dash,
      points: { show: isSinglePoint, size: 6, width: 0, fill: colour },
    }),
  },
];
const noPoints = { points: { show: false } };

function layers(curves) {
  const series = [{}];
  const bands = [];
  for (const { columns, style } of LAYERS) {
    for (const curve of curves) {
      const made = columns(curve).map(() => style(curve));
      if (columns === LAYERS[0].columns && made.length > 0) {
        const fill = faint(curve.colour, BAND_OPACITY);
        bands.push({ series: [series.length, series.length + 1], fill });
      }
      series.push(...made);
    }
  }
  return { series, bands };
}

/** The series indices of the bold lines: the last layer. */
function lineIndices(curves) {
  const before = LAYERS.slice(0, -1).flatMap(({ columns }) => curves.flatMap(columns)).length;
  return new Set(curves.map((_, i) => 1 + before + i));
}

/** A curve's first measurement has no line to be seen by. */
function isSinglePoint(plot, series, from, to) {
  return plot.data[series].slice(from, to + 1).filter((value) => value != null).length === 1;
}

/** uPlot's own ticks on a linear axis; round ones, so many pixels apart, on a logarithmic one. */
function ticks(scale, isLog, spacing) {
  if (!isLog) return {};
  return {
    splits: (plot, _axis, min, max) =>
      roundTicks(min, max, (value) => plot.valToPos(value, scale), spacing),
    filter: (_, splits) => splits,
  };
}

function axis(label, size) {
  return {
    label,
    size,
    labelSize: 18,
    labelGap: 0,
    gap: 6,
    font: canvasFont(),
    labelFont: canvasFont(),
    stroke: () => themeColour("chart-text"),
    grid: { stroke: () => themeColour("chart-grid"), width: 1 },
    ticks: { show: false },
    border: { show: true, stroke: () => themeColour("chart-axis"), width: 1 },
    values: (_, splits) => splits.map((value) => (value === null ? "" : tick(value))),
  };
}

function canvasFont() {
  return `11px ${getComputedStyle(document.body).fontFamily}`;
}

/** Room for the widest label of the y axis. */
function labelWidth(plot, values) {
  if (values === null) return 30;
  plot.ctx.save();
  plot.ctx.font = canvasFont();
  const widest = Math.max(...values.map((text) => plot.ctx.measureText(text).width));
  plot.ctx.restore();
  return Math.ceil(widest) + 12;
}

function cursor(group, lines) {
  return {
    y: false,
    move: (plot, left, top) => [left < 0 ? left : nearestStep(plot, left), top],
    drag: { x: false, y: false, setScale: false },
    sync: { key: group, scales: ["x", null] },
    points: {
      size: 8,
      width: 2,
      stroke: () => themeColour("chart-ground"),
      show: (plot, series) => (lines.has(series) ? document.createElement("div") : null),
    },
  };
}

/** The cursor jumps from step to step, so that it stands on what it reads. */
function nearestStep(plot, left) {
  return plot.data[0].length === 0 ? left : plot.valToPos(plot.data[0][plot.posToIdx(left)], "x");
}

/** Where the random policy and the maximal return lie: hairlines, named at the right edge. */
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
