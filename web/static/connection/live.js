/** Ties a page to the service: fetch at first, on changes, and after a lost connection. */
import { isGuest } from "../parts/caller.js";
import { updateTimes } from "../parts/status.js";
import { here } from "../texts/place.js";
import { EventStream } from "./events.js";
import * as connection from "./state.js";

/** @import { Kind, Payload } from "./broadcast.js" */

const FIRST_FETCH_MILLISECONDS = 500;
const READINESS_MILLISECONDS = 5000;
const TICK_MILLISECONDS = 5000;
const SIGNED_OUT = 401;

/**
 * @param {string} sweep the id of the sweep whose changes matter; "" for those of all
 * @param {(kind: Kind, payload?: Payload) => void} refetch asks for what a change of this kind may
 *   have touched, and for everything when the kind is "reload"
 * @param {(payload: Payload) => void} [printed] a worker printed something, which touches only its
 *   log
 * @returns {EventStream} the stream
 */
export function follow(sweep, refetch, printed = () => {}) {
  let begun = false; // a stream's first message is "reload"
  let missed = false;
  const reload = () => {
    begun = true;
    refetch("reload");
  };
  const stream = new EventStream({
    live: () => {
      connection.live();
      if (missed) reload();
      missed = false;
    },
    lost: () => {
      connection.lost();
      missed = true;
    },
    change: (kind, payload) => {
      if (kind === "reload") reload();
      else if (sweep !== "" && payload.sweep_id !== sweep) return;
      else if (kind === "log") printed(payload);
      else refetch(kind, payload);
    },
  });
  stream.open();
  if (!isGuest) watchReadiness();
  setInterval(updateTimes, TICK_MILLISECONDS);
  setTimeout(() => {
    if (!begun) reload();
  }, FIRST_FETCH_MILLISECONDS);
  return stream;
}

/** Asks now and then what the service lacks, for the banner: space on a disk, a cluster. */
function watchReadiness() {
  setTimeout(async () => {
    if (!document.hidden) await askReadiness();
    watchReadiness();
  }, READINESS_MILLISECONDS);
}

/** Says the first sentence of `/readyz` that tells of something; silence is told elsewhere. */
async function askReadiness() {
  try {
    const response = await fetch(here("/readyz"));
    if (response.status === SIGNED_OUT) return connection.signedOut();
    /** @type {Api.Readiness} */
    const { checks } = await response.json();
    return connection.lacks(checks.find((check) => check.problem)?.problem ?? "");
  } catch {
    return connection.lacks("");
  }
}
