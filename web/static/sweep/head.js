/** The head of a sweep's pages: what it is, how far it is, and what can be done to it. */
import { get, post, refusalOf } from "../connection/api.js";
import * as connection from "../connection/state.js";
import { mayChange, ownerText } from "../parts/caller.js";
import { at, setText } from "../parts/element.js";
import { statusCounts, timeElement } from "../parts/status.js";
import { count, percent } from "../texts/format.js";
import { here } from "../texts/place.js";
import { isActive, stateText, summary } from "../texts/sweep.js";
import { Description } from "./description.js";
import { cancelSweep, deleteSweep } from "./moves.js";
import { loadProblems } from "./problems.js";

export class SweepHead {
  /**
   * As it was fetched last, null before.
   *
   * @type {Api.Sweep | null}
   */
  sweep = null;
  #id;
  #titled;
  #refetch;
  #onMissing;
  #showCounts = statusCounts(at("counts"));
  #description;

  /**
   * @param {string} id
   * @param {string} titled what the page shows of the sweep, for the window's title
   * @param {() => void} refetch asks for `load` to be called
   * @param {() => void} onMissing there is no such sweep
   */
  constructor(id, titled, refetch, onMissing) {
    this.#id = id;
    this.#titled = titled;
    this.#refetch = refetch;
    this.#onMissing = onMissing;
    this.#description = new Description(refetch);
    at("cancel").addEventListener("click", () => this.#act((sweep) => cancelSweep(sweep)));
    at("delete").addEventListener("click", () =>
      this.#act(async (sweep) => {
        if (await deleteSweep(sweep)) location.assign(here("/"));
      }),
    );
    for (const verb of /** @type {const} */ (["pause", "resume", "retry", "uncancel"])) {
      at(verb).addEventListener("click", () => this.#act(() => post(`/sweeps/${id}/${verb}`)));
    }
  }

  /** @param {AbortSignal} signal */
  async load(signal) {
    try {
      this.sweep = await get(`/sweeps/${this.#id}`, {}, signal);
    } catch (error) {
      setText(at("missing"), refusalOf(error, 404).message);
      at("missing").hidden = false;
      at("tabs").hidden = true;
      this.#onMissing();
      return;
    }
    this.#show(this.sweep);
    await loadProblems(this.sweep, signal);
  }

  /** @param {Api.Sweep} sweep */
  #show(sweep) {
    document.title = `${percent(sweep.progress)} · ${sweep.name}${this.#titled} · d3pg`;
    setText(at("name"), sweep.name);
    const submitted = ["submitted", ownerText(sweep.owner)].filter(Boolean).join(" ");
    at("summary").replaceChildren(
      summary(sweep),
      ` · ${submitted} `,
      timeElement(sweep.created_at),
    );
    at("sweep").toggleAttribute("data-others", !mayChange(sweep.owner));
    at("progress", HTMLProgressElement).value = sweep.progress;
    setText(at("percent"), percent(sweep.progress));
    setText(at("remaining"), stateText(sweep));
    setText(at("total"), count(sweep.runs.total));
    const draft = new URLSearchParams({ new: JSON.stringify(sweep.request) });
    const again = at("again", HTMLAnchorElement);
    again.href = here(`/?${draft}`);
    again.hidden = false; // not before: it would lead to an empty form
    this.#showCounts(sweep);
    this.#description.show(sweep);
    showActions(sweep);
  }

  /** @param {(sweep: Api.Sweep) => Promise<unknown>} action */
  async #act(action) {
    if (this.sweep === null) return;
    try {
      if (await action(this.sweep)) this.#refetch();
    } catch (error) {
      connection.refused(refusalOf(error));
    }
  }
}

/**
 * Offer what makes sense now.
 *
 * @param {Api.Sweep} sweep
 */
function showActions(sweep) {
  at("cancel").hidden = !isActive(sweep);
  at("delete").hidden = isActive(sweep);
  at("pause").hidden = sweep.runs.queued === 0;
  at("resume").hidden = sweep.status !== "paused" && sweep.runs.paused === 0;
  at("retry").hidden = sweep.runs.failed === 0;
  at("uncancel").hidden = sweep.runs.cancelled === 0;
}
