/** The inputs of one algorithm: whether it takes part, its weights, its settings. */
import { element } from "../parts/element.js";
import { algorithmColour } from "../parts/palette.js";
import { swatch } from "../parts/swatch.js";
import { settings } from "../texts/schema.js";

const WEIGHTS_HINT = "Pairs, each a curve of its own: 0.1, 0.1; 0.01, 0";

/**
 * @import { Setting } from "../texts/schema.js"
 * @import { Place } from "./faults.js"
 *
 * @typedef {{ input: HTMLInputElement, node: HTMLElement }} WeightsField
 * @typedef {WeightsField & { setting: Setting }} SettingField
 */

export class LearnerFields {
  /** @type {HTMLElement} */
  node;
  /** @type {Api.Algorithm} */
  algorithm;
  #box;
  #reason = element("span", { class: "hint" });
  #details;
  #weights;
  #settings;
  /** @type {string[] | null} */
  #only = null; // the environments that a draft keeps it to, null for all

  /** @param {Api.Algorithm} algorithm */
  constructor(algorithm) {
    this.algorithm = algorithm;
    const { name, summary } = algorithm;
    this.#box = element("input", { type: "checkbox", name: "algorithm", value: name });
    const identity = { colour: algorithmColour(name), dash: [] };
    const text = element("span", { class: "muted" }, summary);
    this.#weights = weightsField(name);
    this.#settings = settings(algorithm.config_schema).map((setting) => settingField(name, setting));
    this.#details = element(
      "div",
      { class: "learner" },
      algorithm.uses_weights ? this.#weights.node : null,
      element(
        "details",
        {},
        element("summary", {}, "Settings"),
        element("div", { class: "settings" }, ...this.#settings.map((field) => field.node)),
      ),
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
      this.isChosen && left.length > 0 ? `not in ${left.join(", ")}: as in the sweep before` : "",
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
    return {
      name: this.algorithm.name,
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
    this.#only = request?.environments ?? null;
    this.#weights.input.value = writeWeights(request?.weights);
    for (const { input, setting } of this.#settings) {
      const value = request?.config?.[setting.name];
      input.value = value === undefined ? "" : JSON.stringify(value).replaceAll(/^"|"$/g, "");
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
    return [...ofSettings, [`${field}.weights`, this.#weights.node], [field, this.node]];
  }

  #fold() {
    this.#details.hidden = !this.isChosen;
  }
}

/**
 * @param {string} name
 * @returns {WeightsField}
 */
function weightsField(name) {
  const id = `weights-${name}`;
  const hint = element("p", { id: `${id}-hint`, class: "hint" }, WEIGHTS_HINT);
  const input = element("input", {
    "type": "text",
    id,
    "autocomplete": "off",
    "aria-describedby": hint.id,
  });
  const label = element("label", { for: id }, "Weights w1, w2");
  return { input, node: element("div", { class: "field" }, label, input, hint) };
}

/**
 * @param {string} name
 * @param {Setting} setting
 * @returns {SettingField}
 */
function settingField(name, setting) {
  const id = `setting-${name}-${setting.name}`;
  const input = element("input", { type: "text", id, autocomplete: "off" });
  const label = element("label", { for: id }, `${setting.name} (${setting.kind})`);
  return { input, setting, node: element("div", { class: "field" }, label, input) };
}

/**
 * What presets say in some environments: one value, or each with its environment.
 *
 * @param {{ name: string, text: string }[]} values
 * @param {string} usual what is said without any environment
 * @returns {string}
 */
export function presetText(values, usual) {
  const texts = [...new Set(values.map(({ text }) => text))];
  if (texts.length < 2) return texts[0] ?? usual;
  const where = (/** @type {string} */ text) => values.filter((each) => each.text === text);
  const parts = texts.map((text) => `${text} in ${where(text).map(({ name }) => name).join(", ")}`);
  return parts.join("; ");
}

/**
 * @param {unknown} value
 * @returns {string}
 */
function settingText(value) {
  return value === undefined || value === null ? "" : JSON.stringify(value).replaceAll('"', "");
}

/**
 * "0.1, 0.1; 0.01, 0" as the request has it; what is no number is for the service to refuse.
 *
 * @param {string} text
 * @returns {object | null}
 */
export function readWeights(text) {
  const pairs = text.split(";").map((pair) => pair.trim());
  const read = pairs.filter(Boolean).map((pair) => {
    const [w1, w2] = pair.split(",").map((each) => readSetting(each.trim()));
    return { w1, ...(w2 === undefined ? {} : { w2 }) };
  });
  if (read.length === 0) return null;
  return read.length === 1 ? read[0] : read;
}

/**
 * @param {Api.AlgorithmRequest["weights"]} weights
 * @returns {string}
 */
function writeWeights(weights) {
  if (weights === undefined || weights === null) return "";
  return [weights].flat().map(({ w1 = 0, w2 = 0 }) => `${w1}, ${w2}`).join("; ");
}

/**
 * A number, truth value or list where the text is one, else the text.
 *
 * @param {string} text
 * @returns {unknown}
 */
export function readSetting(text) {
  try {
    return JSON.parse(text.replace("−", "-"));
  } catch {
    return text;
  }
}
