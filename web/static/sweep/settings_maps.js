/**
 * Settings against the score: a heat map of two, a scatter of one, parallel coordinates of all. The
 * values of a setting stand evenly, in their order, so that grids of decades read as well as others.
 */
import { Controls } from "../parts/controls.js";
import { at, element, setText, shape } from "../parts/element.js";
import { identities, identityOf, varied } from "../parts/identity.js";
import { oneOf, text } from "../parts/view.js";
import { number } from "../texts/format.js";

/**
 * @import { Identities } from "../parts/identity.js"
 * @import { View } from "../parts/view.js"
 *
 * @typedef {typeof MAP_FIELDS} Fields
 * @typedef {{ label: string, stated: Record<string, unknown>, score: number }} Point
 * @typedef {{ name: string, values: string[] }} Scale   a setting's values in their order, as text
 */

export const MAP_FIELDS = {
  map: oneOf("scatter", "heat", "parallel"),
  map_x: text, // a setting; "" for the first that varies
  map_y: text,
  map_task: text, // "" for the mean over tasks
};

const WIDTH = 640;
const HEIGHT = 300;
const MARGIN = { left: 64, right: 24, top: 16, bottom: 40 };
const UNSTATED = "preset";

export class SettingsMaps {
  #view;
  #entries;
  /** @type {Api.ScoreTable | null} */
  #answer = null;

  /**
   * @param {View<Fields>} view
   * @param {() => Api.Entry[]} entries those of the sweep
   */
  constructor(view, entries) {
    this.#view = view;
    this.#entries = entries;
    new Controls(at("map-controls", HTMLFormElement), view);
    view.onChange(() => this.#draw());
    document.addEventListener("themechange", () => this.#draw());
  }

  /** @param {Api.ScoreTable} answer */
  show(answer) {
    this.#answer = answer;
    this.#draw();
  }

  #draw() {
    const names = varied(this.#entries());
    at("settings-maps").hidden = this.#answer === null || names.length === 0;
    if (this.#answer === null || names.length === 0) return;
    offer("map-task", ["", ...this.#answer.environments], "all tasks, mean", this.#view.get("map_task"));
    offer("map-x", names, "", this.#view.get("map_x") || names[0]);
    offer("map-y", names, "", this.#view.get("map_y") || (names[1] ?? names[0]));
    const points = pointsOf(this.#answer, this.#entries(), this.#view.get("map_task"));
    setText(at("map-state"), points.length === 0 ? "No entry has a score there yet." : "");
    const kind = names.length < 2 ? "scatter" : this.#view.get("map");
    at("map-y-choice").hidden = kind !== "heat";
    at("map-x-choice").hidden = kind === "parallel";
    const known = identities(this.#entries());
    const scales = names.map((name) => scaleOf(name, points));
    const x = scaleOf(selected("map-x"), points);
    const y = scaleOf(selected("map-y"), points);
    const draw = {
      heat: () => heatMap(x, y, points),
      scatter: () => scatter(x, points, known),
      parallel: () => parallel(scales, points, known),
    }[kind];
    at("map").replaceChildren(...(points.length === 0 ? [] : [draw()]));
  }
}

/**
 * Entries with their scores in a task, or with the mean over those tasks in which all have one.
 *
 * @param {Api.ScoreTable} answer
 * @param {Api.Entry[]} entries
 * @param {string} task
 * @returns {Point[]}
 */
export function pointsOf({ environments, rows }, entries, task) {
  const stated = new Map(entries.map((entry) => [entry.label, entry.stated]));
  const meanOf = (/** @type {typeof rows[number]} */ row, /** @type {number} */ i) => row.entries[i]?.mean ?? null;
  const every = environments.map((_, i) => i).filter((i) => rows.every((row) => meanOf(row, i) !== null));
  const columns = task === "" ? every : [environments.indexOf(task)];
  return rows.flatMap((row) => {
    const means = columns.map((i) => meanOf(row, i)).filter((mean) => mean !== null);
    if (means.length === 0) return [];
    const score = means.reduce((a, b) => a + b, 0) / means.length;
    return [{ label: row.label, stated: stated.get(row.label) ?? {}, score }];
  });
}

/**
 * @param {string} name
 * @param {Point[]} points
 * @returns {Scale}
 */
export function scaleOf(name, points) {
  const values = [...new Set(points.map(({ stated }) => stated[name]))];
  const rank = (/** @type {unknown} */ value) => (typeof value === "number" ? value : -Infinity);
  return { name, values: values.toSorted((a, b) => rank(a) - rank(b)).map(valueText) };
}

/**
 * @param {unknown} value
 * @returns {string}
 */
function valueText(value) {
  if (value === undefined) return UNSTATED;
  return typeof value === "number" ? number(value) : JSON.stringify(value);
}

/**
 * @param {Scale} scale
 * @param {Point} point
 * @returns {number} of the value of a point among those of the scale
 */
function placeOf({ name, values }, { stated }) {
  return values.indexOf(valueText(stated[name]));
}

/**
 * The mean score of the entries at each pair of values.
 *
 * @param {Scale} x
 * @param {Scale} y
 * @param {Point[]} points
 * @returns {HTMLElement}
 */
function heatMap(x, y, points) {
  const scores = points.map(({ score }) => score);
  const [least, most] = [Math.min(...scores), Math.max(...scores)];
  const heads = x.values.map((value) => element("th", { scope: "col" }, value));
  const rows = y.values.toReversed().map((value) => {
    const own = points.filter((point) => y.values[placeOf(y, point)] === value);
    const cells = x.values.map((_, i) => heatCell(own.filter((point) => placeOf(x, point) === i), least, most));
    return element("tr", {}, element("th", { scope: "row" }, value), ...cells);
  });
  const head = element("tr", {}, element("td", {}, `${y.name} ↑ ${x.name} →`), ...heads);
  const caption = element("caption", { class: "visually-hidden" }, `Score by ${x.name} and ${y.name}`);
  return element(
    "table",
    { class: "data heat" },
    caption,
    element("thead", {}, head),
    element("tbody", {}, ...rows),
  );
}

/**
 * @param {Point[]} points
 * @param {number} least
 * @param {number} most
 * @returns {HTMLElement}
 */
function heatCell(points, least, most) {
  if (points.length === 0) return element("td", { class: "muted" }, "–");
  const score = points.reduce((sum, each) => sum + each.score, 0) / points.length;
  const cell = element("td", { title: points.map(({ label }) => label).join(", ") }, number(score));
  const strength = Math.round((45 * (score - least)) / (most - least || 1));
  cell.style.background = `color-mix(in srgb, var(--accent) ${strength}%, var(--surface))`;
  return cell;
}

/**
 * @param {Scale} x
 * @param {Point[]} points
 * @param {Identities} known
 * @returns {SVGSVGElement}
 */
function scatter(x, points, known) {
  const { drawing, across, up } = frame(x.values, points, `Score by ${x.name}`);
  for (const point of points) {
    const colour = identityOf(known, point.label).colour;
    const dot = shape("circle", { cx: across(placeOf(x, point)), cy: up(point.score), r: 5, fill: colour });
    dot.append(shape("title", {}, new Text(`${point.label}: ${number(point.score)}`)));
    drawing.append(dot);
  }
  drawing.append(label(WIDTH / 2, HEIGHT - 4, x.name, "middle"));
  return drawing;
}

/**
 * @param {Scale[]} scales
 * @param {Point[]} points
 * @param {Identities} known
 * @returns {SVGSVGElement}
 */
function parallel(scales, points, known) {
  const names = [...scales.map(({ name }) => name), "score"];
  const { drawing, across, up } = frame(names, points, "Parallel coordinates of settings and score");
  const height = (/** @type {Scale} */ scale, /** @type {number} */ place) => {
    const span = HEIGHT - MARGIN.top - MARGIN.bottom;
    return HEIGHT - MARGIN.bottom - (span * (place + 0.5)) / scale.values.length;
  };
  scales.forEach((scale, i) => {
    drawing.append(shape("line", { class: "rule", x1: across(i), x2: across(i), y1: MARGIN.top, y2: HEIGHT - MARGIN.bottom }));
    scale.values.forEach((value, place) => {
      drawing.append(label(across(i) - 5, height(scale, place) + 3, value, "end"));
    });
  });
  for (const point of points) {
    const ends = scales.map((scale, i) => `${across(i)},${height(scale, placeOf(scale, point))}`);
    const places = [...ends, `${across(scales.length)},${up(point.score)}`].join(" ");
    const { colour } = identityOf(known, point.label);
    const line = shape("polyline", { "points": places, "stroke": colour, "fill": "none", "stroke-width": 2 });
    line.append(shape("title", {}, new Text(`${point.label}: ${number(point.score)}`)));
    drawing.append(line);
  }
  return drawing;
}

/**
 * A drawing with the scores at its left, or at its right-most column, and columns by name.
 *
 * @param {string[]} columns
 * @param {Point[]} points
 * @param {string} title
 */
function frame(columns, points, title) {
  const drawing = shape("svg", { "viewBox": `0 0 ${WIDTH} ${HEIGHT}`, "class": "map", "role": "img", "aria-label": title });
  const scores = points.map(({ score }) => score);
  const [least, most] = [Math.min(...scores), Math.max(...scores)];
  const step = (WIDTH - MARGIN.left - MARGIN.right) / columns.length;
  const across = (/** @type {number} */ place) => MARGIN.left + step * (place + 0.5);
  const up = (/** @type {number} */ score) => {
    const span = HEIGHT - MARGIN.top - MARGIN.bottom;
    return HEIGHT - MARGIN.bottom - 8 - ((span - 16) * (score - least)) / (most - least || 1);
  };
  columns.forEach((name, i) => drawing.append(label(across(i), HEIGHT - MARGIN.bottom + 16, name, "middle")));
  for (const score of new Set([least, (least + most) / 2, most])) {
    drawing.append(
      shape("line", { class: "rule", x1: MARGIN.left, x2: WIDTH - MARGIN.right, y1: up(score), y2: up(score) }),
      label(MARGIN.left - 6, up(score) + 3, number(score), "end"),
    );
  }
  return { drawing, across, up };
}

/**
 * @param {number} x
 * @param {number} y
 * @param {string} text
 * @param {string} anchor
 * @returns {SVGTextElement}
 */
function label(x, y, text, anchor) {
  return shape("text", { x, y, "text-anchor": anchor }, new Text(text));
}

/**
 * Let a choice have these options; an empty one is called by another name.
 *
 * @param {string} id
 * @param {string[]} values
 * @param {string} unnamed
 * @param {string} chosen
 */
function offer(id, values, unnamed, chosen) {
  const select = at(id, HTMLSelectElement);
  if (String([...select.options].map(({ value }) => value)) !== String(values)) {
    select.replaceChildren(...values.map((value) => element("option", { value }, value || unnamed)));
  }
  select.value = values.includes(chosen) ? chosen : values[0];
}

/**
 * @param {string} id
 * @returns {string}
 */
function selected(id) {
  return at(id, HTMLSelectElement).value;
}
