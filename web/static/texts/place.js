/** Where the service is found: every path of a page begins with what a proxy puts before it. */

/** What stands before `/static/VERSION/texts/place.js`; mostly nothing. */
const ROOT = new URL("../../..", import.meta.url).pathname.replace(/\/$/, "");

/**
 * The address of a path of the service, such as `/sweeps/ID` or `/api/v1/sweeps`.
 *
 * @param {string} path
 * @returns {string}
 */
export function here(path) {
  return ROOT + path;
}

/**
 * The path of the page that is open, with its query, as `here` takes it.
 *
 * @returns {string}
 */
export function thisPath() {
  return location.pathname.slice(ROOT.length) + location.search;
}
