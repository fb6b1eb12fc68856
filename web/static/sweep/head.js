/** The head of a sweep's pages: what it is, how far it is, and what can be done to it. */
import { get, post } from "../connection/api.js";
import * as connection from "../connection/state.js";
import { setText } from "../parts/element.js";
import { statusCounts, timeElement } from "../parts/status.js";
import { count, percent } from "../texts/format.js";
import { isActive, stateText, summary } from "../texts/sweep.js";
import { cancelSweep } from "./moves.js";
import { loadProblems } from "./problems.js";

const at = (name) => document.getElementById(name);

export class SweepHead {
  /** The sweep as it was fetched last, null before. */
  sweep = null;
  #id;
  #titled;
  #refetch;
  #onMissing;
  #showCounts = statusCounts(at("counts"));

  /**
   * @param titled what the page shows of the sweep, for the window's title
   * @param refetch () => void; asks for `load` to be called
   * @param onMissing () => void; there is no such sweep
   */
  constructor(id, titled, refetch, onMissing) {
    this.#id = id;
    this.#titled = titled;
    this.#refetch = refetch;
    this.#onMissing = onMissing;
    at("cancel").addEventListener("click", () => this.#act(() => cancelSweep(this.sweep)));
    for (const verb of ["pause", "resume", "retry"]) {
      at(verb).addEventListener("click", () => this.#act(() => post(`/sweeps/${id}/${verb}`)));
    }
  }

  async load(signal) {
    try {
      this.sweep = await get(`/sweeps/${this.#id}`, {}, signal);
    } catch (error) {
      if (error.status !== 404) throw error;
      setText(at("missing"), error.message);
      at("missing").hidden = false;
      at("tabs").hidden = true;
      this.#onMissing();
      return;
    }
    this.#show();
    await loadProblems(this.sweep, signal);
  }

  #show() {
    const sweep = this.sweep;
    document.title = `${percent(sweep.progress)} · ${sweep.name}${this.#titled} · d3pg`;
    setText(at("name"), sweep.name);
    at("summary").replaceChildren(summary(sweep), " · submitted ", timeElement(sweep.created_at));
    at("progress").value = sweep.progress;
    setText(at("percent"), percent(sweep.progress));
    setText(at("remaining"), stateText(sweep));
    setText(at("total"), count(sweep.runs.total));
    at("again").href = `/?${new URLSearchParams({ new: JSON.stringify(sweep.request) })}`;
    this.#showCounts(sweep);
    showActions(sweep);
  }

  async #act(action) {
    try {
      if (await action()) this.#refetch();
    } catch (refusal) {
      connection.refused(refusal);
    }
  }
}

/** Offer what makes sense now. */
function showActions(sweep) {
  at("cancel").hidden = !isActive(sweep);
  at("pause").hidden = sweep.runs.queued === 0;
  at("resume").hidden = sweep.status !== "paused" && sweep.runs.paused === 0;
  at("retry").hidden = sweep.runs.failed === 0;
}
