/** Ties a page to the service: fetch at first, on changes, and after a lost connection. */
import { EventStream } from "./events.js";
import * as connection from "./state.js";

/** @import { Kind, Payload } from "./events.js" */

const FIRST_FETCH_MILLISECONDS = 500;
const READINESS_MILLISECONDS = 5000;

/**
 * @param {string} url of the event stream
 * @param {(kind: Kind, payload?: Payload) => void} refetch asks for what a change of this kind may
 *   have touched, and for everything when the kind is "reload"
 * @returns {EventStream} the stream
 */
export function follow(url, refetch) {
  let begun = false; // a stream's first message is "reload"
  let missed = false;
  const reload = () => {
    begun = true;
    refetch("reload");
  };
  const stream = new EventStream(url, {
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
      else refetch(kind, payload);
    },
  });
  stream.open();
  watchReadiness();
  setTimeout(() => {
    if (!begun) reload();
  }, FIRST_FETCH_MILLISECONDS);
  return stream;
}

/** Asks now and then what the service lacks, for the banner: space on a disk, a cluster. */
function watchReadiness() {
  setTimeout(async () => {
    if (!document.hidden) connection.lacks(await problem());
    watchReadiness();
  }, READINESS_MILLISECONDS);
}

/**
 * The first sentence of `/readyz` that tells of something; that nobody answers is told elsewhere.
 *
 * @returns {Promise<string>}
 */
async function problem() {
  try {
    /** @type {Api.Readiness} */
    const { checks } = await (await fetch("/readyz")).json();
    return checks.find((check) => check.problem)?.problem ?? "";
  } catch {
    return "";
  }
}
