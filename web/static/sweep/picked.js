/** The selected sweeps of the list: compared, or put into the archive and taken out of it. */
import { patch, refusalOf } from "../connection/api.js";
import { at, setText } from "../parts/element.js";
import { count, counted } from "../texts/format.js";

/** @import { Field, View } from "../parts/view.js" */

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
      location.assign(`/compare?${query}`);
    });
    at("archive-picked").addEventListener("click", () => this.#archive(true));
    at("restore-picked").addEventListener("click", () => this.#archive(false));
    at("unpick").addEventListener("click", () => view.set({ pick: [] }));
    view.onChange(() => this.update());
    this.update();
  }

  /** Say how many are selected; nothing while none is. */
  update() {
    const { length } = this.#view.get("pick");
    at("picked").hidden = length === 0;
    setText(at("picked-count"), `${counted(length, "sweep")} selected`);
  }

  /**
   * @param {string} id
   * @param {boolean} isPicked
   */
  pick(id, isPicked) {
    const others = this.#view.get("pick").filter((each) => each !== id);
    this.#view.set({ pick: isPicked ? [...others, id] : others });
  }

  /** @param {boolean} archived */
  async #archive(archived) {
    const ids = this.#view.get("pick");
    try {
      for (const id of ids) await patch(`/sweeps/${id}`, { archived });
      setText(at("picked-state"), `${count(ids.length)} ${archived ? "archived" : "taken out"}`);
      this.#view.set({ pick: [] });
    } catch (error) {
      setText(at("picked-state"), refusalOf(error).message);
    }
    this.#refetch();
  }
}
