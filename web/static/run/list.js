/** Rows of runs: where each stands and why, its return so far, selecting it, stopping it. */
import { Sparkline } from "../charts/sparkline.js";
import { refusalOf } from "../connection/api.js";
import * as connection from "../connection/state.js";
import { element, keyed, setText } from "../parts/element.js";
import { varied } from "../parts/identity.js";
import { algorithmColour } from "../parts/palette.js";
import { statusMark } from "../parts/status.js";
import { count, number } from "../texts/format.js";
import { here } from "../texts/place.js";
import { activityText, canCancel, canRetry, statusText, tookText } from "../texts/run.js";
import { cancelRun, retryRun } from "./moves.js";

/**
 * @import { Entry } from "../parts/identity.js"
 * @import { Field, View } from "../parts/view.js"
 *
 * @typedef {{ run: Api.ListedRun, settings: [name: string, text: string][] }} Row   settings: those
 *   in which the entries of the sweep differ
 */

export class RunList {
  /** @type {(rows: Row[]) => void} */
  #show;
  #view;
  #refetch;

  /**
   * @param {HTMLElement} body
   * @param {View<{ pick: Field<string[]> }>} view its field "pick" lists the ids that are selected
   * @param {() => void} refetch a run was changed
   */
  constructor(body, view, refetch) {
    this.#view = view;
    this.#refetch = refetch;
    this.#show = keyed(
      body,
      (/** @type {Row} */ { run, settings }) => [run.id, ...settings.map(([name]) => name)].join(" "),
      (row) => this.#row(row),
    );
  }

  /**
   * Show these runs and no others.
   *
   * @param {Api.ListedRun[]} runs
   * @param {Entry[]} entries of the sweep
   */
  show(runs, entries) {
    const names = varied(entries);
    const stated = new Map(entries.map((entry) => [entry.label, entry.stated ?? {}]));
    this.#show(
      runs.map((run) => {
        const values = stated.get(run.label) ?? {};
        return { run, settings: names.map((name) => [name, settingText(values[name])]) };
      }),
    );
  }

  /**
   * @param {Row} first
   * @returns {{ node: HTMLElement, update: (row: Row) => void }}
   */
  #row(first) {
    let { run } = first;
    const ordinal = run.id.slice(run.id.indexOf("-") + 1);
    const box = element("input", { "type": "checkbox", "aria-label": `Select run ${ordinal}` });
    box.addEventListener("change", () => this.#pick(run.id, box.checked));
    const state = element("span");
    const activity = element("span", { class: "activity" });
    const reason = element("span", { class: "reason" });
    const sparkline = new Sparkline(algorithmColour(run.algorithm));
    const numbers = [1, 2, 3, 4].map(() => element("td", { class: "number" }));
    const [score, latest, timesteps, took] = numbers;
    const cancel = this.#button("Cancel", ordinal, () => cancelRun(run));
    const retry = this.#button("Retry", ordinal, () => retryRun(run));
    const node = element(
      "tr",
      {},
      element("td", {}, box),
      element("th", { scope: "row" }, element("a", { href: here(`/runs/${run.id}`) }, ordinal)),
      element("td", {}, state, activity, reason),
      element("td", {}, run.environment),
      element("td", {}, run.label),
      ...first.settings.map(([, text]) => element("td", { class: "number" }, text)),
      element("td", { class: "number" }, String(run.seed)),
      element("td", {}, sparkline.node),
      ...numbers,
      element("td", { "data-needs": "own" }, cancel, retry),
    );
    const update = (/** @type {Row} */ now) => {
      ({ run } = now);
      box.checked = this.#view.get("pick").includes(run.id);
      state.replaceChildren(statusMark(run.status), statusText(run));
      const values = run.sparkline ?? [];
      sparkline.update(values, run.timestep / run.timesteps);
      setText(score, run.score === null ? "" : number(run.score));
      setText(latest, values.length > 0 ? number(values.at(-1)) : "");
      setText(timesteps, `${count(run.timestep)} / ${count(run.timesteps)}`);
      setText(took, tookText(run));
      setText(activity, activityText(run));
      setText(reason, run.reason ?? "");
      cancel.hidden = !canCancel(run);
      retry.hidden = !canRetry(run);
    };
    return { node, update };
  }

  /**
   * @param {string} text
   * @param {string} ordinal
   * @param {() => Promise<unknown>} action
   * @returns {HTMLButtonElement}
   */
  #button(text, ordinal, action) {
    const button = element("button", { type: "button", class: "quiet" }, text);
    button.setAttribute("aria-label", `${text} run ${ordinal}`);
    button.addEventListener("click", async () => {
      try {
        if (await action()) this.#refetch();
      } catch (error) {
        connection.refused(refusalOf(error));
      }
    });
    return button;
  }

  /**
   * @param {string} id
   * @param {boolean} isPicked
   */
  #pick(id, isPicked) {
    const others = this.#view.get("pick").filter((each) => each !== id);
    this.#view.set({ pick: isPicked ? [...others, id] : others });
  }
}

/**
 * @param {unknown} value
 * @returns {string}
 */
function settingText(value) {
  if (value === undefined) return "preset";
  return typeof value === "number" ? number(value) : JSON.stringify(value);
}
