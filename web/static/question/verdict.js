/** What a sweep's question has come to: a sentence a comparison, and its interval as it narrows. */
import { get } from "../connection/api.js";
import { at, element, keyed, setText } from "../parts/element.js";
import { identities, identityOf } from "../parts/identity.js";
import { swatch } from "../parts/swatch.js";
import { counted, percent } from "../texts/format.js";
import { extentOf, narrowing } from "./narrowing.js";

/** @import { Identity } from "../parts/identity.js" */
/** @import { Extent } from "./narrowing.js" */
/**
 * @typedef {object} Shown
 * @property {Api.Comparison} comparison
 * @property {number} margin
 * @property {Extent} extent
 * @property {Identity} identity
 */

const DECIDED = ["better", "worse", "equivalent"];
const DRAWN =
  "Drawn, all to one scale: the mean of the differences and its interval over the pairs seen, the " +
  "line at 0, and the differences that do not matter in grey.";

export class Verdict {
  #id;
  #entries;
  /** @type {Api.Verdict | null} */
  #answer = null;
  #show = keyed(
    at("verdict-comparisons"),
    (/** @type {Shown} */ { comparison: { environment, label } }) => `${environment} ${label}`,
    () => new Comparison(),
  );

  /**
   * @param {string} id
   * @param {() => Api.Entry[]} entries those of the sweep
   */
  constructor(id, entries) {
    this.#id = id;
    this.#entries = entries;
    document.addEventListener("themechange", () => this.#draw());
    at("verdict-copy").addEventListener("click", () => this.#copy());
  }

  /**
   * Only a sweep that asks a question has a verdict.
   *
   * @param {AbortSignal} signal
   */
  async load(signal) {
    this.#answer = await get(`/sweeps/${this.#id}/verdict`, {}, signal);
    at("verdict").hidden = false;
    this.#draw();
  }

  #draw() {
    if (this.#answer === null) return;
    const { comparisons, margin, paper, kept_apart: apart, definition } = this.#answer;
    const known = identities(this.#entries());
    const extent = extentOf(comparisons.map(({ sequence }) => sequence), margin);
    this.#show(
      comparisons.map((comparison) => ({
        comparison,
        margin,
        extent,
        identity: identityOf(known, comparison.label),
      })),
    );
    setText(at("verdict-paper"), paper);
    setText(at("verdict-apart"), apart);
    setText(at("verdict-definition"), `${DRAWN} ${definition}`);
  }

  async #copy() {
    await navigator.clipboard.writeText(this.#answer?.paper ?? "");
    setText(at("verdict-copy"), "Copied");
    setTimeout(() => setText(at("verdict-copy"), "Copy"), 2000);
  }
}

class Comparison {
  #title = element("h3");
  #sentence = element("p");
  #picture = element("div");
  #rest = element("small");
  node = element("li", {}, this.#title, this.#sentence, this.#picture, this.#rest);

  /** @param {Shown} shown */
  update({ comparison, margin, extent, identity }) {
    const { environment, label, against, outcome, sentence, sequence } = comparison;
    this.#title.replaceChildren(swatch(identity), `${environment}: ${label} vs ${against}`);
    setText(this.#sentence, sentence.replaceAll(/-(?=\d)/g, "−"));
    this.#sentence.classList.toggle("decided", DECIDED.includes(outcome));
    this.#picture.replaceChildren(narrowing(sequence, margin, identity.colour, extent));
    setText(this.#rest, rest(comparison));
  }
}

/**
 * What the sentence does not say: pairs that do not count, divergence, power.
 *
 * @param {Api.Comparison} comparison
 * @returns {string}
 */
function rest({ n, left_out, unequal, diverged, diverged_against: theirs, confidence, forecast }) {
  const parts = [`${counted(n, "pair")}, interval of ${(100 * confidence).toFixed(1)} %`];
  const lost = left_out - unequal;
  if (lost > 0) parts.push(`${counted(lost, "pair")} left out: runs failed or were cancelled`);
  if (unequal > 0) parts.push(`${counted(unequal, "pair")} left out: different processors`);
  if (diverged + theirs > 0) parts.push(`${diverged} of ours and ${theirs} of theirs diverged`);
  if (forecast !== null) parts.push(`power ${percent(forecast.power)} within the budget`);
  return parts.join("; ");
}
