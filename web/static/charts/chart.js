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
import { themeColour } from "../parts/palette.js";
import { axis, canvasFont, labelWidth, ticks } from "./axes.js";
import { align, layers, lineIndices } from "./layers.js";

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
