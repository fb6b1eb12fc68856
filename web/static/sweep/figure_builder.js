/** The builder of a figure for a paper: what is chosen, and beside it the file as it will be. */
import { address, get, refusalOf } from "../connection/api.js";
import { Controls } from "../parts/controls.js";
import { at, element, keyed, setText } from "../parts/element.js";
import { identities, identityOf } from "../parts/identity.js";
import { figureQuery, shownEntries } from "./figure_query.js";

/**
 * @import { Entry } from "../parts/identity.js"
 * @import { View } from "../parts/view.js"
 * @import { Fields } from "./figure_query.js"
 *
 * @typedef {{ label: string, colour: string, name: string }} Row
 */

const PAUSE_MILLISECONDS = 300;
const FORMS = ["png", "svg", "pdf", "csv"];

export class FigureBuilder {
  #id;
  #view;
  #details = at("figure-builder", HTMLDetailsElement);
  #preview = element("img", { id: "figure-preview", alt: "Preview of the figure" });
  #showEntries;
  #showTasks;
  /** @type {Api.Panel[]} */
  #panels = [];
  /** @type {number | null} */
  #xMax = null;
  #drawn = "";
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /**
   * @param {() => string} id of the sweep, or of several that are joined
   * @param {View<Fields>} view
   */
  constructor(id, view) {
    this.#id = id;
    this.#view = view;
    new Controls(at("figure-form", HTMLFormElement), view);
    this.#showEntries = keyed(
      at("figure-entries"),
      (/** @type {Row} */ { label }) => label,
      (row) => this.#entryRow(row),
    );
    this.#showTasks = keyed(
      at("figure-tasks"),
      (/** @type {string} */ task) => task,
      (task) => this.#taskRow(task),
    );
    this.#details.addEventListener("toggle", () => this.#draw());
    this.#preview.addEventListener("error", () => this.#tellFault());
    this.#preview.addEventListener("load", () => setText(at("figure-state"), ""));
  }

  /**
   * Keep up with what is on the screen.
   *
   * @param {Api.Panel[]} panels
   * @param {Entry[]} entries
   * @param {number | null} xMax where the x axis ends, if that is known
   */
  update(panels, entries, xMax) {
    this.#panels = panels;
    this.#xMax = xMax;
    for (const form of FORMS) {
      const link = at(`download-${form === "csv" ? "data" : form}`, HTMLAnchorElement);
      link.href = this.#address(form);
      link.download = `sweep-${this.#id()}.${form}`;
    }
    at("download-report", HTMLAnchorElement).href = address(`/sweeps/${this.#id()}/report`);
    const known = identities(entries);
    const [names, colours] = [pairs(this.#view.get("name")), pairs(this.#view.get("colour"))];
    this.#showEntries(
      shownEntries(this.#view, panels).map((label) => ({
        label,
        name: names.get(label) ?? "",
        colour: colours.get(label) ?? identityOf(known, label).colour,
      })),
    );
    this.#showTasks(this.#tasks);
    this.#draw();
  }

  /** The tasks, those that are shown first and in their order. */
  get #tasks() {
    const all = this.#panels.map(({ environment }) => environment);
    const chosen = this.#view.get("task").filter((task) => all.includes(task));
    return [...chosen, ...all.filter((task) => !chosen.includes(task))];
  }

  /**
   * @param {string} form
   * @returns {string}
   */
  #address(form) {
    return address(`/sweeps/${this.#id()}/plot.${form}`, figureQuery(this.#view, this.#panels, this.#xMax));
  }

  #draw() {
    const wanted = this.#address("svg");
    if (!this.#details.open || wanted === this.#drawn) return;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.#drawn = wanted;
      setText(at("figure-state"), "Drawing …");
      this.#preview.src = wanted;
      at("figure-frame").prepend(this.#preview);
    }, PAUSE_MILLISECONDS);
  }

  /** Say why there is no picture: its data are refused for the same reasons. */
  async #tellFault() {
    try {
      const query = figureQuery(this.#view, this.#panels, this.#xMax);
      await get(`/sweeps/${this.#id()}/plot.csv`, query);
    } catch (error) {
      setText(at("figure-state"), refusalOf(error).message);
    }
  }

  /**
   * @param {Row} first
   * @returns {{ node: HTMLElement, update: (row: Row) => void }}
   */
  #entryRow({ label }) {
    const colour = element("input", { "type": "color", "aria-label": `Colour of ${label}` });
    const name = element("input", { "type": "text", "placeholder": label, "aria-label": `Name of ${label}` });
    colour.addEventListener("change", () => this.#set("colour", label, colour.value));
    name.addEventListener("change", () => this.#set("name", label, name.value.trim()));
    const up = button("Up", label, () => {
      this.#view.set({ entry: raised(shownEntries(this.#view, this.#panels), label) });
    });
    const node = element("li", {}, colour, name, up);
    const update = (/** @type {Row} */ row) => {
      colour.value = row.colour;
      name.value = row.name;
    };
    return { node, update };
  }

  /**
   * @param {string} task
   * @returns {{ node: HTMLElement, update: () => void }}
   */
  #taskRow(task) {
    const box = element("input", { type: "checkbox" });
    box.addEventListener("change", () => this.#showTask(task, box.checked));
    const up = button("Up", task, () => this.#view.set({ task: raised(this.#shownTasks, task) }));
    const update = () => {
      box.checked = this.#shownTasks.includes(task);
      up.hidden = !box.checked;
    };
    return { node: element("li", {}, element("label", {}, box, task), up), update };
  }

  get #shownTasks() {
    const chosen = this.#view.get("task");
    return chosen.length > 0 ? chosen : this.#tasks;
  }

  /**
   * @param {string} task
   * @param {boolean} isShown
   */
  #showTask(task, isShown) {
    const others = this.#shownTasks.filter((each) => each !== task);
    this.#view.set({ task: isShown ? [...others, task] : others });
  }

  /**
   * @param {"name" | "colour"} field
   * @param {string} label
   * @param {string} value
   */
  #set(field, label, value) {
    const texts = pairs(this.#view.get(field));
    if (value) texts.set(label, value);
    else texts.delete(label);
    this.#view.set({ [field]: [...texts].map(([each, text]) => `${each}=${text}`) });
  }
}

/**
 * "label=value" by label, which may have signs of equality itself.
 *
 * @param {string[]} texts
 * @returns {Map<string, string>}
 */
function pairs(texts) {
  return new Map(
    texts.map((text) => [text.slice(0, text.lastIndexOf("=")), text.slice(text.lastIndexOf("=") + 1)]),
  );
}

/**
 * A list with one of its items a place further ahead.
 *
 * @param {string[]} items
 * @param {string} item
 * @returns {string[]}
 */
function raised(items, item) {
  const place = items.indexOf(item);
  if (place < 1) return items;
  return [...items.slice(0, place - 1), item, items[place - 1], ...items.slice(place + 1)];
}

/**
 * @param {string} text
 * @param {string} of
 * @param {() => void} onclick
 * @returns {HTMLButtonElement}
 */
function button(text, of, onclick) {
  return element("button", { type: "button", class: "quiet", "aria-label": `${text}: ${of}`, onclick }, text);
}
