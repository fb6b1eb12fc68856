/** The selected runs: compared, or moved one after the other, whatever page of the list they are on. */
import { post, refusalOf } from "../connection/api.js";
import { confirm } from "../parts/confirm.js";
import { at, setText } from "../parts/element.js";
import { count, counted } from "../texts/format.js";
import { statusText } from "../texts/run.js";

/** @import { Field, View } from "../parts/view.js" */
/** @typedef {"pause" | "resume" | "retry" | "cancel"} Verb */

/** @type {Verb[]} */
const VERBS = ["pause", "resume", "retry", "cancel"];

export class Picked {
  #view;
  #refetch;
  #moving = false;

  /**
   * @param {View<{ pick: Field<string[]> }>} view its field "pick" lists the ids that are selected
   * @param {() => void} refetch runs were moved
   */
  constructor(view, refetch) {
    this.#view = view;
    this.#refetch = refetch;
    at("compare").addEventListener("click", () => {
      const query = new URLSearchParams(this.#ids.map((id) => ["run", id]));
      location.assign(`/compare?${query}`);
    });
    at("unpick").addEventListener("click", () => {
      setText(at("picked-state"), "");
      view.set({ pick: [] });
    });
    for (const verb of VERBS) {
      at(`${verb}-picked`).addEventListener("click", () => this.#move(verb));
    }
    this.update();
  }

  get #ids() {
    return this.#view.get("pick");
  }

  /** Say how many are selected. */
  update() {
    const { length } = this.#ids;
    setText(at("picked-count"), length === 0 ? "None selected" : `${count(length)} selected`);
    for (const button of at("picked").querySelectorAll("button")) {
      button.disabled = length === 0 || this.#moving;
    }
  }

  /** @param {Verb} verb */
  async #move(verb) {
    const ids = [...this.#ids];
    if (verb === "cancel" && !(await isMeant(ids.length))) return;
    this.#moving = true;
    this.update();
    /** @type {string[]} */
    const statuses = []; // where the runs stand now
    /** @type {string[]} */
    const refusals = [];
    for (const id of ids) {
      try {
        statuses.push(statusText(await post(`/runs/${id}/${verb}`)));
      } catch (error) {
        const refusal = refusalOf(error);
        refusals.push(refusal.message);
        if (refusal.status === 0 || refusal.status === 401) break; // so would the others be
      }
      setText(at("picked-state"), `${statuses.length + refusals.length} of ${ids.length} …`);
    }
    this.#moving = false;
    setText(at("picked-state"), result(statuses, refusals));
    this.update();
    this.#refetch();
  }
}

/**
 * @param {number} length
 * @returns {Promise<boolean>}
 */
function isMeant(length) {
  return confirm({
    title: `Cancel ${counted(length, "run")}?`,
    detail:
      "Those that have not ended will stop for good. The other runs go on, and what was measured " +
      "stays.",
    yes: length === 1 ? "Cancel the run" : "Cancel the runs",
    no: "Let them run",
  });
}

/**
 * "3 paused. 1 refused: Run ...-4 has succeeded ..."
 *
 * @param {string[]} statuses
 * @param {string[]} refusals
 * @returns {string}
 */
function result(statuses, refusals) {
  const kinds = [...new Set(statuses)];
  const parts = kinds.map((kind) => `${statuses.filter((each) => each === kind).length} ${kind}`);
  const now = parts.length === 0 ? "" : `${parts.join(", ")}. `;
  return now + (refusals.length === 0 ? "" : `${refusals.length} refused: ${refusals[0]}`);
}
