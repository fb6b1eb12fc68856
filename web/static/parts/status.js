/** Where sweeps and runs stand, as marks and counts; and how long ago something was. */
import { ago, count, dateAndTime } from "../texts/format.js";
import { element, keyed, setText } from "./element.js";

/** @type {Api.RunStatus[]} */
const STATUSES = ["running", "queued", "paused", "succeeded", "failed", "diverged", "cancelled"];

/**
 * A list of "3 running" entries that keeps up with a sweep's counts; statuses of 0 are left out.
 *
 * @param {HTMLElement} list
 * @returns {(sweep: Api.SweepHead) => void}
 */
export function statusCounts(list) {
  const show = keyed(
    list,
    ({ status }) => status,
    ({ status }) => {
      const text = element("span");
      const node = element("li", {}, statusMark(status), text);
      return { node, update: ({ amount }) => setText(text, `${count(amount)} ${status}`) };
    },
  );
  return ({ runs }) =>
    show(
      STATUSES.map((status) => ({ status, amount: runs[status] })).filter(({ amount }) => amount > 0),
    );
}

/**
 * A dot in the colour and shape of a status; the word stands beside it.
 *
 * @param {string} status
 * @returns {HTMLElement}
 */
export function statusMark(status) {
  return element("span", { "class": "mark", "data-status": status, "aria-hidden": "true" });
}

/**
 * A `<time>` that reads "3 min ago" and grows older by itself through `updateTimes`.
 *
 * @param {string} iso
 * @returns {HTMLElement}
 */
export function timeElement(iso) {
  const date = new Date(iso);
  return element("time", { datetime: iso, title: dateAndTime(date) }, ago(date));
}

/** Let every time on the page say how long ago it is now. */
export function updateTimes() {
  for (const time of document.querySelectorAll("time")) setText(time, ago(new Date(time.dateTime)));
}
