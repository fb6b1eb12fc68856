/** The runs of a sweep: how far each is, why one failed, and cancelling one. */
import { post } from "./api.js";
import { confirm } from "./confirm.js";
import * as connection from "./connection.js";
import { element, keyed, setText } from "./element.js";
import { count, counted, duration, number } from "./format.js";
import { Listing } from "./paging.js";
import { statusMark } from "./sweep_text.js";

const PAGE = 20;
const REASONS_SHOWN = 8;

export class Runs {
  #sweepId;
  #view;
  #listing;
  #refetch;
  #rows = keyed(document.querySelector("#runs tbody"), (run) => run.id, (run) => this.#row(run));

  /** @param refetch () => void; asks for `load` to be called */
  constructor(sweepId, view, refetch) {
    this.#sweepId = sweepId;
    this.#view = view;
    this.#refetch = refetch;
    this.#listing = new Listing(`/sweeps/${sweepId}/runs`, PAGE);
    const choice = document.getElementById("runs-status");
    choice.value = view.get("runs");
    choice.addEventListener("change", () => view.set({ runs: choice.value }));
    view.addEventListener("change", ({ detail: fields }) => {
      if (!fields.includes("runs")) return;
      choice.value = view.get("runs");
      this.#listing.restart();
      refetch();
    });
    document.getElementById("more-runs").addEventListener("click", () => {
      this.#listing.extend();
      refetch();
    });
  }

  /** Fetch and show the runs read so far. */
  async load(signal) {
    const chosen = this.#view.get("runs");
    const status = chosen === "all" ? null : chosen;
    const { items, hasMore } = await this.#listing.fetch({ status }, signal);
    this.#rows(items);
    document.getElementById("no-runs").hidden = items.length > 0;
    document.getElementById("more-runs").hidden = !hasMore;
  }

  /** Say in one place what went wrong, each reason once; asks only when the counts moved. */
  async loadProblems(counts, signal) {
    const statuses = ["failed", "diverged"].filter((status) => counts[status] > 0);
    const parts = statuses.map((status) => `${counted(counts[status], "run")} ${status}`);
    const text = `${parts.join(", ")}.`;
    const box = document.getElementById("problems");
    const summary = box.querySelector("p");
    if (statuses.length === 0 || summary.textContent === text) return;
    const path = `/sweeps/${this.#sweepId}/runs`;
    const lists = statuses.map((status) => new Listing(path, PAGE).fetch({ status }, signal));
    const runs = (await Promise.all(lists)).flatMap(({ items }) => items);
    setText(summary, text);
    box.querySelector("ul").replaceChildren(...reasons(runs));
    box.hidden = false;
  }

  #row(run) {
    const status = element("td");
    const timesteps = element("td", { class: "number" });
    const took = element("td", { class: "number" });
    const reason = element("td", { class: "reason" });
    const actions = element("td");
    const cancel = element("button", { type: "button", class: "quiet" }, "Cancel");
    cancel.setAttribute("aria-label", `Cancel run ${run.id}`);
    cancel.addEventListener("click", () => this.#cancel(run));
    const node = element(
      "tr",
      {},
      status,
      element("td", {}, run.environment),
      element("td", {}, learnerText(run)),
      element("td", { class: "number" }, String(run.seed)),
      timesteps,
      took,
      reason,
      actions,
    );
    const update = (latest) => {
      status.replaceChildren(statusMark(latest.status), statusText(latest));
      setText(timesteps, `${count(latest.timestep)} / ${count(latest.timesteps)}`);
      setText(took, tookText(latest));
      setText(reason, latest.reason ?? "");
      const canCancel = ["queued", "running"].includes(latest.status) && !latest.is_cancelling;
      if (!canCancel) cancel.remove();
      else if (!cancel.isConnected) actions.append(cancel);
    };
    return { node, update };
  }

  async #cancel(run) {
    const meant = await confirm({
      title: "Cancel this run?",
      detail:
        `${learnerText(run)} in ${run.environment}, seed ${run.seed}, will stop for good. ` +
        "The other runs go on, and what was measured stays.",
      yes: "Cancel the run",
      no: "Let it run",
    });
    if (!meant) return;
    try {
      await post(`/runs/${run.id}/cancel`);
      this.#refetch();
    } catch (refusal) {
      connection.refused(refusal);
    }
  }
}

/** "hybrid-ddpg, w1 0.1, w2 0.1". */
function learnerText({ algorithm, weights: { w1, w2 } }) {
  return w1 === 0 && w2 === 0 ? algorithm : `${algorithm}, w1 ${number(w1)}, w2 ${number(w2)}`;
}

function statusText({ status, is_cancelling: isCancelling }) {
  return isCancelling && status === "running" ? "cancelling" : status;
}

function tookText({ started_at: start, finished_at: end }) {
  return start && end ? duration((new Date(end) - new Date(start)) / 1000) : "";
}

function reasons(runs) {
  const groups = new Map();
  for (const run of runs) {
    const text = run.reason || "no reason was recorded";
    groups.set(text, [...(groups.get(text) ?? []), run]);
  }
  const shown = [...groups].slice(0, REASONS_SHOWN).map(([text, alike]) => {
    const [first] = alike;
    const others = alike.length > 1 ? ` and ${alike.length - 1} more` : "";
    const who = `${learnerText(first)} in ${first.environment}, seed ${first.seed}${others}: `;
    return element("li", {}, who, element("span", { class: "reason" }, text));
  });
  const hidden = groups.size - shown.length;
  return hidden > 0 ? [...shown, element("li", {}, `${hidden} other reasons`)] : shown;
}
