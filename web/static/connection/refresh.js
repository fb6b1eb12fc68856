import { isDropped, Refusal } from "./api.js";

const RETRY_MILLISECONDS = 5000;

/** Fetch again when something changed, but neither twice at once nor more often than asked. */
export class Refresh {
  #work;
  #interval;
  #onError;
  #wanted = false;
  #urgent = false;
  #running = false;
  #current = new AbortController();
  #wake = () => {};

  /**
   * @typedef {object} Options
   * @property {number} interval   milliseconds between the starts of two fetches; more when fetches
   *   are slow, so that at least half of the time is left to others
   * @property {(error: Error) => void} onError   the work is tried again after five seconds, unless
   *   what it asked for is wrong
   *
   * @param {(signal: AbortSignal) => Promise<void>} work what fetches and shows
   * @param {Options} options
   */
  constructor(work, { interval, onError }) {
    this.#work = work;
    this.#interval = interval;
    this.#onError = onError;
    document.addEventListener("visibilitychange", () => this.#run());
  }

  /** Something changed. Calls made before the next fetch begins count as one. */
  request() {
    this.#wanted = true;
    this.#run();
  }

  /** A person asked for something else: drop the fetch under way and begin at once. */
  hurry() {
    this.#urgent = true;
    this.#current.abort();
    this.request();
    this.#wake();
  }

  async #run() {
    if (this.#running) return;
    this.#running = true;
    while (this.#wanted && !document.hidden) await this.#turn();
    this.#running = false;
  }

  async #turn() {
    this.#wanted = this.#urgent = false;
    this.#current = new AbortController();
    const started = performance.now();
    let failed = false;
    try {
      await this.#work(this.#current.signal);
    } catch (error) {
      if (!isDropped(error)) {
        const isFinal = error instanceof Refusal && error.isFinal;
        failed = !isFinal;
        this.#wanted ||= failed;
        this.#onError(/** @type {Error} */ (error));
      }
    }
    const took = performance.now() - started;
    if (this.#urgent) return;
    await this.#pause(failed ? RETRY_MILLISECONDS : Math.max(this.#interval - took, took));
  }

  /**
   * @param {number} milliseconds
   * @returns {Promise<void>}
   */
  #pause(milliseconds) {
    return new Promise((resolve) => {
      this.#wake = resolve;
      setTimeout(resolve, milliseconds);
    });
  }
}
