/** One move of many sweeps or runs, as one request. */
import { post } from "./api.js";
import { count } from "../texts/format.js";

/** @type {Record<Api.BulkMove, string>} */
const DONE = {
  pause: "paused",
  resume: "resumed",
  retry: "queued again",
  cancel: "cancelled",
  uncancel: "queued again",
  delete: "deleted",
  archive: "archived",
  unarchive: "unarchived",
};

/**
 * Ask for it. Throws Refusal.
 *
 * @param {Api.BulkMove} move
 * @param {string[]} ids
 * @returns {Promise<string>} "3 paused. 1 refused: run ...-4 has succeeded ..."
 */
export async function moveAll(move, ids) {
  const { moved, refused } = await post("/moves", { move, ids });
  const now = moved.length > 0 ? `${count(moved.length)} ${DONE[move]}. ` : "";
  const not = refused.length > 0 ? `${count(refused.length)} refused: ${refused[0].reason}.` : "";
  return (now + not).trim();
}
