const FIRST_RETRY_MILLISECONDS = 1000;
const LONGEST_RETRY_MILLISECONDS = 15000;

/**
 * The one event stream of this tab. When it breaks the browser opens it again and sends
 * Last-Event-ID, so the service goes on where it broke off, or says "reload" where it cannot.
 *
 * Dispatches "live", "lost", and "change" with detail { kind, payload }; kind is "sweep", "run",
 * "measurements" or "reload".
 */
export class EventStream extends EventTarget {
  #url;
  #source = null;
  #retryAfter = FIRST_RETRY_MILLISECONDS;

  constructor(url) {
    super();
    this.#url = url;
    window.addEventListener("pagehide", () => this.close());
    window.addEventListener("pageshow", (event) => event.persisted && this.open());
  }

  open() {
    const source = new EventSource(this.#url);
    this.#source = source;
    source.addEventListener("open", () => {
      this.#retryAfter = FIRST_RETRY_MILLISECONDS;
      this.dispatchEvent(new Event("live"));
    });
    source.addEventListener("error", () => this.#lost(source));
    for (const kind of ["sweep", "run", "measurements", "reload"]) {
      source.addEventListener(kind, ({ data }) => {
        const detail = { kind, payload: JSON.parse(data) };
        this.dispatchEvent(new CustomEvent("change", { detail }));
      });
    }
  }

  /** End it for good: also an attempt that is still to come. */
  close() {
    this.#source?.close();
    this.#source = null;
  }

  #lost(source) {
    if (source !== this.#source) return;
    this.dispatchEvent(new Event("lost"));
    if (source.readyState !== EventSource.CLOSED) return;
    // A refusal (a proxy's 502, say) ends the browser's own attempts: go on with ours.
    setTimeout(() => source === this.#source && this.open(), this.#retryAfter);
    this.#retryAfter = Math.min(2 * this.#retryAfter, LONGEST_RETRY_MILLISECONDS);
  }
}
