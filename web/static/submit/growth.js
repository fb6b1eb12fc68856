/** The form that gives a sweep more: seeds, entries or timesteps; what that is, is said first. */
import { isDropped, post, refusalOf } from "../connection/api.js";
import { at, field, setText, within } from "../parts/element.js";
import { clearFaults, showFaults } from "../parts/faults.js";
import { estimateText } from "./plan.js";
import { readSetting } from "./values.js";

const PAUSE_MILLISECONDS = 300;
const RANGE = /^(\d+)\s*-\s*(\d+)$/;
const MOST_SEEDS = 10_000; // of a range: a slip of the finger is not to fill the memory

export class Growth {
  #id;
  #onGrown;
  #form = at("growth", HTMLFormElement);
  #opener = at("add-runs", HTMLButtonElement);
  #submitter = within(this.#form, "[type=submit]", HTMLButtonElement);
  #asking = new AbortController();
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /**
   * @param {string} id of the sweep
   * @param {() => void} onGrown
   */
  constructor(id, onGrown) {
    this.#id = id;
    this.#onGrown = onGrown;
    this.#opener.addEventListener("click", () => this.#open(this.#form.hidden));
    within(this.#form, "[name=close]").addEventListener("click", () => this.#open(false));
    this.#form.addEventListener("input", () => this.#onInput());
    this.#form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#send();
    });
  }

  /**
   * Offer the form where the sweep can grow.
   *
   * @param {Api.Sweep} sweep
   */
  show({ status, request }) {
    this.#opener.hidden = status === "cancelled" || Boolean(request.question);
  }

  /** @param {boolean} isOpen */
  #open(isOpen) {
    this.#form.hidden = !isOpen;
    this.#opener.setAttribute("aria-expanded", String(isOpen));
    if (isOpen) this.#onInput();
    (isOpen ? this.#input : this.#opener).focus();
  }

  /** @returns {"seeds" | "algorithms" | "timesteps"} */
  get #kind() {
    const kind = String(new FormData(this.#form).get("kind"));
    return kind === "algorithms" || kind === "timesteps" ? kind : "seeds";
  }

  get #input() {
    const kind = this.#kind;
    return kind === "algorithms"
      ? field(this.#form, kind, HTMLTextAreaElement)
      : field(this.#form, kind, HTMLInputElement);
  }

  /** What `POST /sweeps/{id}/runs` takes. */
  get #request() {
    const read = { seeds: seedsOf, algorithms: algorithmsOf, timesteps: readSetting };
    return { [this.#kind]: read[this.#kind](this.#input.value.trim()) };
  }

  #onInput() {
    for (const part of this.#form.querySelectorAll("[data-fault]")) {
      part.toggleAttribute("hidden", part.getAttribute("data-fault") !== this.#kind);
    }
    this.#submitter.disabled = true;
    this.#complain([], "");
    setText(at("growth-product"), "");
    clearTimeout(this.#timer);
    this.#asking.abort();
    if (this.#input.value.trim() === "") return;
    this.#timer = setTimeout(() => this.#ask(), PAUSE_MILLISECONDS);
  }

  /** Let the service count and estimate, and find what is wrong. */
  async #ask() {
    this.#asking = new AbortController();
    try {
      const path = /** @type {const} */ (`/sweeps/${this.#id}/runs?dry_run=true`);
      const answer = await post(path, this.#request, {}, this.#asking.signal);
      setText(at("growth-product"), estimateText(/** @type {Api.Plan} */ (answer)));
      this.#submitter.disabled = false;
    } catch (error) {
      if (!isDropped(error)) this.#refused(error);
    }
  }

  async #send() {
    if (this.#submitter.disabled) return;
    this.#submitter.disabled = true; // pressed twice, it adds once
    try {
      await post(`/sweeps/${this.#id}/runs`, this.#request);
      this.#input.value = "";
      this.#open(false);
      this.#onGrown();
    } catch (error) {
      this.#refused(error);
    }
  }

  /** @param {unknown} error */
  #refused(error) {
    const { errors, message } = refusalOf(error);
    this.#complain(errors, message);
  }

  /**
   * @param {Api.Fault[]} errors
   * @param {string} message
   */
  #complain(errors, message) {
    clearFaults(this.#form);
    const homeless = showFaults(errors, [[this.#kind, this.#input.parentElement ?? this.#form]]);
    const rest = errors.length > 0 ? homeless.join(" ") : message;
    setText(at("growth-fault"), rest);
    at("growth-fault").hidden = rest === "";
  }
}

/**
 * "16-31, 40" as a list; what is no number is for the service to refuse.
 *
 * @param {string} text
 * @returns {unknown[]}
 */
function seedsOf(text) {
  return text.split(",").flatMap((part) => {
    const [, first, last] = RANGE.exec(part.trim()) ?? [];
    const count = Number(last) - Number(first) + 1;
    const isRange = count > 0 && count <= MOST_SEEDS;
    return isRange ? Array.from({ length: count }, (_, i) => Number(first) + i) : [readSetting(part.trim())];
  });
}

/**
 * Entries as `d3pg add` takes them, one a line: "hybrid-ddpg:0.1,0.01:noise=0.1,0.2".
 *
 * @param {string} text
 * @returns {object[]}
 */
function algorithmsOf(text) {
  const lines = text.split("\n").map((line) => line.trim());
  return lines.filter(Boolean).map((line) => {
    const [name, ...parts] = line.split(":").map((part) => part.trim());
    return parts.reduce(withPart, { name });
  });
}

/**
 * @typedef {{ name: string, label?: string, zip?: string[], weights?: object, config?: object }} Algorithm
 */

/**
 * @param {Algorithm} algorithm
 * @param {string} part
 * @returns {Algorithm}
 */
function withPart(algorithm, part) {
  const [key, value] = part.split(/=(.*)/s);
  if (value === undefined) {
    const [w1, w2] = [readSetting(part)].flat();
    return { ...algorithm, weights: { w1, w2 } };
  }
  if (key === "label") return { ...algorithm, label: value };
  if (key === "zip") return { ...algorithm, zip: value.split(",") };
  const place = key === "w1" || key === "w2" ? "weights" : "config";
  return { ...algorithm, [place]: { ...algorithm[place], [key]: readSetting(value) } };
}
