/** Ties a page to the service: fetch at first, on changes, and after a lost connection. */
import * as connection from "./connection.js";
import { EventStream } from "./events.js";
import { watch } from "./readiness.js";

const FIRST_FETCH_MILLISECONDS = 500;

/**
 * @param url of the event stream
 * @param refetch (kind, payload) => void; asks for what a change of this kind may have touched, and
 *   for everything when the kind is "reload"
 * @returns the stream
 */
export function follow(url, refetch) {
  const stream = new EventStream(url);
  let begun = false; // a stream's first message is "reload"
  let missed = false;
  const reload = () => {
    begun = true;
    refetch("reload");
  };
  stream.addEventListener("live", () => {
    connection.live();
    if (missed) reload();
    missed = false;
  });
  stream.addEventListener("lost", () => {
    connection.lost();
    missed = true;
  });
  stream.addEventListener("change", ({ detail: { kind, payload } }) => {
    if (kind === "reload") reload();
    else refetch(kind, payload);
  });
  stream.open();
  watch();
  setTimeout(() => begun || reload(), FIRST_FETCH_MILLISECONDS);
  return stream;
}
