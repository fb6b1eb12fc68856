/** The selected runs: compared, or moved together, whatever page of the list they are on. */
import { refusalOf } from "../connection/api.js";
import { moveAll } from "../connection/bulk.js";
import { confirm } from "../parts/confirm.js";
import { at, setText } from "../parts/element.js";
import { count, counted } from "../texts/format.js";
import { here } from "../texts/place.js";

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
      location.assign(here(`/compare?${query}`));
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
    setText(at("picked-state"), await moveAll(verb, ids).catch((error) => refusalOf(error).message));
    this.#moving = false;
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
      "Runs that have not ended will stop for good. The other runs go on, and measurements stay.",
    yes: length === 1 ? "Cancel the run" : "Cancel the runs",
    no: "Let them run",
  });
}
