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
    this.#source = new EventSource(this.#url);
    this.#source.addEventListener("open", () => {
      this.#retryAfter = FIRST_RETRY_MILLISECONDS;
      this.dispatchEvent(new Event("live"));
    });
    this.#source.addEventListener("error", () => this.#lost());
    for (const kind of ["sweep", "run", "measurements", "reload"]) {
      this.#source.addEventListener(kind, ({ data }) => {
        const detail = { kind, payload: JSON.parse(data) };
        this.dispatchEvent(new CustomEvent("change", { detail }));
      });
    }
  }

  close() {
    this.#source.close();
  }

  #lost() {
    this.dispatchEvent(new Event("lost"));
    if (this.#source.readyState !== EventSource.CLOSED) return;
    // A refusal (a proxy's 502, say) ends the browser's own attempts: go on with ours.
    const refused = this.#source;
    setTimeout(() => refused === this.#source && this.open(), this.#retryAfter);
    this.#retryAfter = Math.min(2 * this.#retryAfter, LONGEST_RETRY_MILLISECONDS);
  }
}
