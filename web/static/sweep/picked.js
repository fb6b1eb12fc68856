/** The selected sweeps of the list: compared, archived, stopped or deleted together. */
import { refusalOf } from "../connection/api.js";
import { moveAll } from "../connection/bulk.js";
import { confirm } from "../parts/confirm.js";
import { at, setText } from "../parts/element.js";
import { counted } from "../texts/format.js";
import { here } from "../texts/place.js";

/** @import { Field, View } from "../parts/view.js" */

/** @type {Api.BulkMove[]} */
const MOVES = ["archive", "unarchive", "cancel", "delete"];

export class PickedSweeps {
  #view;
  #refetch;

  /**
   * @param {View<{ pick: Field<string[]> }>} view its field "pick" lists the ids that are selected
   * @param {() => void} refetch sweeps were changed
   */
  constructor(view, refetch) {
    this.#view = view;
    this.#refetch = refetch;
    at("compare-picked").addEventListener("click", () => {
      const query = new URLSearchParams(view.get("pick").map((id) => ["sweep", id]));
      location.assign(here(`/compare?${query}`));
    });
    for (const move of MOVES) {
      at(`${move}-picked`).addEventListener("click", () => this.#move(move));
    }
    at("unpick").addEventListener("click", () => {
      setText(at("picked-state"), "");
      view.set({ pick: [] });
    });
    view.onChange(() => this.update());
    this.update();
  }

  /** Say how many are selected; nothing while none is. */
  update() {
    const { length } = this.#view.get("pick");
    at("picked").hidden = length === 0 && at("picked-state").textContent === "";
    setText(at("picked-count"), `${counted(length, "sweep")} selected`);
  }

  /**
   * Let go of sweeps that are not listed any more.
   *
   * @param {string[]} ids those that are
   */
  keep(ids) {
    const kept = this.#view.get("pick").filter((id) => ids.includes(id));
    if (kept.length < this.#view.get("pick").length) this.#view.set({ pick: kept });
  }

  /**
   * @param {string} id
   * @param {boolean} isPicked
   */
  pick(id, isPicked) {
    const others = this.#view.get("pick").filter((each) => each !== id);
    this.#view.set({ pick: isPicked ? [...others, id] : others });
  }

  /** @param {Api.BulkMove} move */
  async #move(move) {
    const ids = this.#view.get("pick");
    if (move === "delete" && !(await isMeant(ids.length))) return;
    try {
      setText(at("picked-state"), await moveAll(move, ids));
    } catch (error) {
      setText(at("picked-state"), refusalOf(error).message);
    }
    this.#refetch();
  }
}

/**
 * @param {number} length
 * @returns {Promise<boolean>}
 */
function isMeant(length) {
  return confirm({
    title: `Delete ${counted(length, "sweep")}?`,
    detail:
      "This deletes their measurements and policies, too, for good. Sweeps that have not ended " +
      "are refused.",
    yes: length === 1 ? "Delete the sweep" : "Delete the sweeps",
    no: "Keep them",
  });
}
