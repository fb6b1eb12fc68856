import { address } from "./api.js";

const FIRST_RETRY_MILLISECONDS = 1000;
const LONGEST_RETRY_MILLISECONDS = 15000;

/** @typedef {"sweep" | "run" | "measurements" | "diagnosis" | "log" | "reload"} Kind */
/** @typedef {{ sweep_id?: string, run_id?: string, run_ids?: string[] }} Payload what a change concerns */
/** @typedef {{ kind: Kind | "live" | "lost", payload?: Payload }} News */

/** @type {Kind[]} */
const KINDS = ["sweep", "run", "measurements", "diagnosis", "log", "reload"];

/**
 * One event stream for every port that listens. When it breaks the browser opens it again and sends
 * Last-Event-ID, so the service goes on where it broke off, or says "reload" where it cannot.
 */
export class Broadcast {
  /** @type {Set<MessagePort>} */
  #ports = new Set();
  /** @type {EventSource | null} */
  #source = null;
  /** @type {"connecting" | "live" | "lost"} */
  #state = "connecting";
  #retryAfter = FIRST_RETRY_MILLISECONDS;

  /**
   * Let a port hear of every change from now on; whatever it sends means that it has heard enough.
   *
   * @param {MessagePort} port
   */
  add(port) {
    port.addEventListener("message", () => this.#remove(port));
    port.start();
    this.#ports.add(port);
    if (this.#state !== "connecting") send(port, { kind: this.#state });
    if (this.#state === "live") send(port, { kind: "reload" });
    if (this.#source === null) this.#open();
  }

  /** @param {MessagePort} port */
  #remove(port) {
    this.#ports.delete(port);
    if (this.#ports.size > 0) return;
    this.#source?.close();
    this.#source = null;
    this.#state = "connecting";
  }

  #open() {
    const source = new EventSource(address("/events"));
    this.#source = source;
    source.addEventListener("open", () => {
      this.#retryAfter = FIRST_RETRY_MILLISECONDS;
      this.#turn("live");
    });
    source.addEventListener("error", () => this.#lost(source));
    for (const kind of KINDS) {
      source.addEventListener(kind, ({ data }) => this.#tell({ kind, payload: JSON.parse(data) }));
    }
  }

  /** @param {EventSource} source */
  #lost(source) {
    if (source !== this.#source) return;
    this.#turn("lost");
    if (source.readyState !== EventSource.CLOSED) return;
    // A refusal (a proxy's 502, say) ends the browser's own attempts: go on with ours.
    setTimeout(() => source === this.#source && this.#open(), this.#retryAfter);
    this.#retryAfter = Math.min(2 * this.#retryAfter, LONGEST_RETRY_MILLISECONDS);
  }

  /** @param {"live" | "lost"} state */
  #turn(state) {
    this.#state = state;
    this.#tell({ kind: state });
  }

  /** @param {News} news */
  #tell(news) {
    for (const port of this.#ports) send(port, news);
  }
}

/**
 * @param {MessagePort} port
 * @param {News} news
 */
function send(port, news) {
  port.postMessage(news);
}
