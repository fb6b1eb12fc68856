import { Broadcast } from "./broadcast.js";

/** @import { Kind, News, Payload } from "./broadcast.js" */

/** What this tab hears of the browser's one event stream. */
export class EventStream {
  #listener;
  /** @type {MessagePort | null} */
  #port = null;

  /**
   * @typedef {object} Listener
   * @property {() => void} live   the stream is open
   * @property {() => void} lost   it broke
   * @property {(kind: Kind, payload: Payload) => void} change
   *
   * @param {Listener} listener
   */
  constructor(listener) {
    this.#listener = listener;
    window.addEventListener("pagehide", () => this.close());
    window.addEventListener("pageshow", (event) => {
      if (event.persisted) this.open();
    });
  }

  open() {
    this.#port = connected();
    this.#port.addEventListener("message", ({ data }) => this.#hear(data));
    this.#port.start();
  }

  /** End it for good. */
  close() {
    this.#port?.postMessage("enough");
    this.#port?.close();
    this.#port = null;
  }

  /** @param {News} news */
  #hear({ kind, payload = {} }) {
    if (kind === "live") this.#listener.live();
    else if (kind === "lost") this.#listener.lost();
    else this.#listener.change(kind, payload);
  }
}

/**
 * A port to the worker that all tabs share; where a browser has no such workers, as some on phones,
 * to a stream of this tab.
 *
 * @returns {MessagePort}
 */
function connected() {
  if ("SharedWorker" in globalThis) {
    const script = new URL("./stream_worker.js", import.meta.url);
    return new SharedWorker(script, { type: "module", name: "d3pg events" }).port;
  }
  const { port1, port2 } = new MessageChannel();
  new Broadcast().add(port1);
  return port2;
}
