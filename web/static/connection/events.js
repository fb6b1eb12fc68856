const FIRST_RETRY_MILLISECONDS = 1000;
const LONGEST_RETRY_MILLISECONDS = 15000;

/** @typedef {"sweep" | "run" | "measurements" | "diagnosis" | "reload"} Kind */
/** @typedef {{ sweep_id?: string, run_id?: string }} Payload what a change concerns */

/** @type {Kind[]} */
const KINDS = ["sweep", "run", "measurements", "diagnosis", "reload"];

/**
 * The one event stream of this tab. When it breaks the browser opens it again and sends
 * Last-Event-ID, so the service goes on where it broke off, or says "reload" where it cannot.
 */
export class EventStream {
  #url;
  #listener;
  /** @type {EventSource | null} */
  #source = null;
  #retryAfter = FIRST_RETRY_MILLISECONDS;

  /**
   * @typedef {object} Listener
   * @property {() => void} live   the stream is open
   * @property {() => void} lost   it broke
   * @property {(kind: Kind, payload: Payload) => void} change
   *
   * @param {string} url
   * @param {Listener} listener
   */
  constructor(url, listener) {
    this.#url = url;
    this.#listener = listener;
    window.addEventListener("pagehide", () => this.close());
    window.addEventListener("pageshow", (event) => {
      if (event.persisted) this.open();
    });
  }

  open() {
    const source = new EventSource(this.#url);
    this.#source = source;
    source.addEventListener("open", () => {
      this.#retryAfter = FIRST_RETRY_MILLISECONDS;
      this.#listener.live();
    });
    source.addEventListener("error", () => this.#lost(source));
    for (const kind of KINDS) {
      source.addEventListener(kind, ({ data }) => this.#listener.change(kind, JSON.parse(data)));
    }
  }

  /** End it for good: also an attempt that is still to come. */
  close() {
    this.#source?.close();
    this.#source = null;
  }

  /** @param {EventSource} source */
  #lost(source) {
    if (source !== this.#source) return;
    this.#listener.lost();
    if (source.readyState !== EventSource.CLOSED) return;
    // A refusal (a proxy's 502, say) ends the browser's own attempts: go on with ours.
    setTimeout(() => source === this.#source && this.open(), this.#retryAfter);
    this.#retryAfter = Math.min(2 * this.#retryAfter, LONGEST_RETRY_MILLISECONDS);
  }
}
