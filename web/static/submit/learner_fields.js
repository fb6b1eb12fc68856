/** The inputs of one item of a request: an algorithm, its label, its weights, its settings. */
import { element } from "../parts/element.js";
import { algorithmColour } from "../parts/palette.js";
import { swatch } from "../parts/swatch.js";
import { settings } from "../texts/schema.js";
import {
  presetText,
  readSetting,
  readWeights,
  settingText,
  writeSetting,
  writeWeights,
} from "./values.js";

const WEIGHTS_HINT = "Pairs, each a curve of its own: 0.1, 0.1; 0.01, 0. A list is a grid: [0.1, 1], 0";
const GRID_HINT = "A list is a grid, every combination a curve: 0.1, 0.2";
const TOGETHER_HINT = "Names of lists above that advance together instead: rate, tau";

/**
 * @import { Setting } from "../texts/schema.js"
 * @import { Place } from "../parts/faults.js"
 *
 * @typedef {{ input: HTMLInputElement, node: HTMLElement }} TextField
 * @typedef {TextField & { setting: Setting }} SettingField
 */

export class LearnerFields {
  /** @type {HTMLElement} */
  node;
  /** @type {Api.Algorithm} */
  algorithm;
  #box;
  #label;
  #together;
  #reason = element("span", { class: "hint" });
  #details;
  #weights;
  #settings;
  /** @type {string[] | null} */
  #only = null; // the environments that a draft keeps it to, null for all

  /**
   * @param {Api.Algorithm} algorithm
   * @param {object} among the items of the same algorithm
   * @param {number} among.place 0 for the one that its checkbox chooses; the others are removed
   * @param {() => void} among.onAnother asks for one more
   * @param {() => void} among.onRemove asks for this one to be taken away
   */
  constructor(algorithm, { place, onAnother, onRemove }) {
    this.algorithm = algorithm;
    const { name, summary } = algorithm;
    const id = place === 0 ? name : `${name}-${place + 1}`;
    this.#box = element("input", { type: "checkbox", name: "algorithm", value: name });
    this.#box.checked = this.#box.hidden = place > 0;
    const identity = { colour: algorithmColour(name), dash: [] };
    const text = element("span", { class: "muted" }, place === 0 ? summary : "another entry");
    this.#label = textField(`label-${id}`, "Label", "Shown instead of the algorithm’s name");
    this.#weights = textField(`weights-${id}`, "Weights w1, w2", WEIGHTS_HINT);
    this.#together = textField(`together-${id}`, "Together", TOGETHER_HINT);
    this.#settings = settings(algorithm.config_schema).map((setting) => settingField(id, setting));
    const another = element(
      "button",
      { type: "button", class: "quiet", onclick: onAnother },
      `Another entry of ${name}`,
    );
    const remove = element("button", { type: "button", class: "quiet", onclick: onRemove }, "Remove");
    remove.setAttribute("aria-label", `Remove this entry of ${name}`);
    remove.hidden = place === 0;
    this.#details = element(
      "div",
      { class: "learner" },
      algorithm.uses_weights ? this.#weights.node : null,
      this.#label.node,
      element(
        "details",
        {},
        element("summary", {}, "Settings"),
        element("p", { class: "hint" }, GRID_HINT),
        element("div", { class: "settings" }, ...this.#settings.map((field) => field.node)),
        this.#together.node,
      ),
      element("p", { class: "view-actions" }, another, remove),
    );
    this.node = element(
      "div",
      { class: "option" },
      element("label", {}, this.#box, swatch(identity), name, text, this.#reason),
      this.#details,
    );
    this.#box.addEventListener("input", () => this.#fold());
    this.#fold();
  }

  get isChosen() {
    return this.#box.checked;
  }

  /** Whether its algorithm has another item before it. */
  get isAdded() {
    return this.#box.hidden;
  }

  /**
   * Say which of the chosen environments it takes no part in, without any of which it cannot be
   * chosen, and what runs in the others where a field is left empty.
   *
   * @param {string[]} chosen
   */
  limit(chosen) {
    this.#showPresets(this.#able(chosen));
    const lacking = chosen.filter((each) => !(each in this.algorithm.presets));
    const left = chosen.filter((each) => this.#only !== null && !this.#only.includes(each));
    this.#box.disabled = !this.isChosen && chosen.length > 0 && this.#able(chosen).length === 0;
    this.#reason.textContent = [
      lacking.length > 0 ? `not in ${lacking.join(", ")}: its reward has no gradient` : "",
      this.isChosen && left.length > 0 ? `not in ${left.join(", ")}: as in the previous sweep` : "",
    ]
      .filter(Boolean)
      .join("; ");
  }

  /** @param {string[]} environments */
  #showPresets(environments) {
    const presets = environments.map((name) => ({ name, ...this.algorithm.presets[name] }));
    for (const { input, setting } of this.#settings) {
      const values = presets.map(({ name, config }) => {
        return { name, text: settingText(config[setting.name] ?? setting.initial) };
      });
      input.placeholder = presetText(values, settingText(setting.initial));
    }
    const pairs = presets.map(({ name, weights: { w1, w2 } }) => ({ name, text: `${w1}, ${w2}` }));
    this.#weights.input.placeholder = presetText(pairs, "the preset’s");
  }

  /**
   * What `POST /sweeps` takes of it, with these environments.
   *
   * @param {string[]} chosen
   * @returns {object}
   */
  request(chosen) {
    const weights = this.algorithm.uses_weights ? readWeights(this.#weights.input.value) : null;
    const config = Object.fromEntries(
      this.#settings
        .filter(({ input }) => input.value.trim() !== "")
        .map(({ input, setting }) => [setting.name, readSetting(input.value.trim())]),
    );
    const label = this.#label.input.value.trim();
    const together = this.#together.input.value.split(",").map((each) => each.trim()).filter(Boolean);
    return {
      name: this.algorithm.name,
      ...(label ? { label } : {}),
      ...(together.length > 0 ? { zip: together } : {}),
      ...(weights === null ? {} : { weights }),
      ...(Object.keys(config).length > 0 ? { config } : {}),
      ...(this.#able(chosen).length < chosen.length ? { environments: this.#able(chosen) } : {}),
    };
  }

  /**
   * Those of the chosen environments that it can learn in and is not kept from.
   *
   * @param {string[]} chosen
   * @returns {string[]}
   */
  #able(chosen) {
    const isIn = (/** @type {string} */ name) => this.#only === null || this.#only.includes(name);
    return chosen.filter((name) => name in this.algorithm.presets && isIn(name));
  }

  /**
   * Show such a request; undefined: not chosen.
   *
   * @param {Api.AlgorithmRequest | undefined} request
   */
  fill(request) {
    this.#box.checked = request !== undefined;
    this.#label.input.value = request?.label ?? "";
    this.#together.input.value = request?.zip?.join(", ") ?? "";
    this.#only = request?.environments ?? null;
    this.#weights.input.value = writeWeights(request?.weights);
    for (const { input, setting } of this.#settings) {
      const value = request?.config?.[setting.name];
      input.value = value === undefined ? "" : writeSetting(value);
    }
    this.#fold();
  }

  /**
   * The parts that faults of the i-th algorithm of the request belong to.
   *
   * @param {number} i
   * @returns {Place[]}
   */
  places(i) {
    const field = `algorithms[${i}]`;
    /** @type {Place[]} */
    const ofSettings = this.#settings.map(({ node, setting }) => {
      return [`${field}.config.${setting.name}`, node];
    });
    return [
      ...ofSettings,
      [`${field}.weights`, this.#weights.node],
      [`${field}.label`, this.#label.node],
      [`${field}.zip`, this.#together.node],
      [field, this.node],
    ];
  }

  #fold() {
    this.#details.hidden = !this.isChosen;
  }
}

/**
 * @param {string} id
 * @param {string} title
 * @param {string} text
 * @returns {TextField}
 */
function textField(id, title, text) {
  const hint = element("p", { id: `${id}-hint`, class: "hint" }, text);
  const input = element("input", {
    "type": "text",
    id,
    "autocomplete": "off",
    "aria-describedby": hint.id,
  });
  const label = element("label", { for: id }, title);
  return { input, node: element("div", { class: "field" }, label, input, hint) };
}

/**
 * @param {string} owner
 * @param {Setting} setting
 * @returns {SettingField}
 */
function settingField(owner, setting) {
  const id = `setting-${owner}-${setting.name}`;
  const input = element("input", { type: "text", id, autocomplete: "off" });
  const label = element("label", { for: id }, `${setting.name} (${setting.kind})`);
  return { input, setting, node: element("div", { class: "field" }, label, input) };
}
