/** "Tell me when it is done": a notification of the browser, also while the tab is hidden. */
import { get, refusalOf } from "../connection/api.js";
import * as connection from "../connection/state.js";
import { at, setText } from "../parts/element.js";
import { isActive, stateText } from "../texts/sweep.js";

const PAUSE_MILLISECONDS = 3000; // between two looks at the sweep

export class DoneNotice {
  #id;
  #button = at("tell", HTMLButtonElement);
  #isAwaited = false;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #look;

  /** @param {string} id of the sweep */
  constructor(id) {
    this.#id = id;
    this.#button.addEventListener("click", () => this.#ask());
  }

  /**
   * Offer it while there is something to wait for, where the browser has notifications.
   *
   * @param {Api.Sweep} sweep
   */
  offer(sweep) {
    this.#button.hidden = !isActive(sweep) || !("Notification" in globalThis);
  }

  /** The sweep changed. Fetches of the page wait while it is hidden; this one does not. */
  changed() {
    if (!this.#isAwaited || this.#look !== undefined) return;
    this.#look = setTimeout(() => this.#see(), PAUSE_MILLISECONDS);
  }

  async #ask() {
    if (this.#isAwaited) return this.#await(false);
    const answer = await Notification.requestPermission();
    if (answer === "granted") return this.#await(true);
    connection.refused(new Error("The browser does not allow notifications of this page."));
  }

  /** @param {boolean} isAwaited */
  #await(isAwaited) {
    this.#isAwaited = isAwaited;
    this.#button.setAttribute("aria-pressed", String(isAwaited));
    setText(this.#button, isAwaited ? "Will tell you" : "Tell me when it is done");
  }

  async #see() {
    this.#look = undefined;
    try {
      const sweep = await get(`/sweeps/${this.#id}`);
      if (isActive(sweep) || !this.#isAwaited) return;
      this.#await(false);
      new Notification(sweep.name, { body: stateText(sweep), tag: sweep.id });
    } catch (error) {
      refusalOf(error); // the next change asks again
    }
  }
}
