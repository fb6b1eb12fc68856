/**
 * Runs once in a browser, for all of its tabs. A browser opens six connections to a host at most:
 * with a stream in each tab, the sixth would have none left to load anything with.
 */
import { Broadcast } from "./broadcast.js";

const broadcast = new Broadcast();
globalThis.addEventListener("connect", (event) => {
  broadcast.add(/** @type {MessageEvent} */ (event).ports[0]);
});
