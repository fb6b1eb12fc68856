/** How often a run was claimed, how each attempt ended, and what its worker prints. */
import { element, keyed, setText } from "../parts/element.js";
import { statusMark, timeElement } from "../parts/status.js";
import { count, duration, secondsBetween } from "../texts/format.js";

/**
 * @param {HTMLElement} list
 * @returns {(attempts: Api.Attempt[]) => void} shows them in the list, the latest
 *   first
 */
export function attemptList(list) {
  const show = keyed(list, (attempt) => attempt.attempt, entry);
  return (attempts) => show(attempts.toReversed());
}

/**
 * @param {Api.Attempt} first
 * @returns {{ node: HTMLElement, update: (attempt: Api.Attempt) => void }}
 */
function entry(first) {
  const outcome = element("span");
  const took = element("span", { class: "muted" });
  const note = element("p", { class: "muted" });
  const error = block("Error");
  const log = block("Log of the worker", { open: first.outcome !== "succeeded", follows: true });
  const node = element(
    "li",
    { value: String(first.attempt) },
    element(
      "p",
      {},
      outcome,
      element("span", { class: "muted" }, ` on ${first.worker}, `),
      timeElement(first.started_at),
      took,
    ),
    note,
    error.node,
    log.node,
  );
  const update = (/** @type {Api.Attempt} */ attempt) => {
    outcome.replaceChildren(statusMark(attempt.outcome), attempt.outcome);
    const { started_at: start, ended_at: end, resumed_timestep: from } = attempt;
    const resumed = from ? `, resumed at ${count(from)}` : "";
    setText(took, (end === null ? "" : `, took ${duration(secondsBetween(start, end))}`) + resumed);
    setText(note, attempt.note ?? "");
    error.update(attempt.error);
    log.update(attempt.log_tail);
  };
  return { node, update };
}

/**
 * @param {string} title
 * @param {{ open?: boolean, follows?: boolean }} [options] follows: its end stays in sight, unless
 *   the reader has scrolled away from it
 * @returns {{ node: HTMLElement, update: (content: string) => void }}
 */
function block(title, { open = true, follows = false } = {}) {
  const text = element("pre", { "tabindex": "0", "aria-label": title });
  const node = element("details", { open }, element("summary", {}, title), text);
  const toEnd = () => follows && text.scrollTo(0, text.scrollHeight);
  node.addEventListener("toggle", toEnd);
  const update = (/** @type {string} */ content) => {
    const isAtEnd = text.scrollTop + text.clientHeight >= text.scrollHeight - 1;
    setText(text, content);
    node.hidden = content === "";
    if (isAtEnd) toEnd();
  };
  return { node, update };
}
