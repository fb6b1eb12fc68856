/** How often a run was claimed, and how each attempt ended: the error, the worker's last words. */
import { element, keyed, setText } from "../parts/element.js";
import { statusMark, timeElement } from "../parts/status.js";
import { count, duration } from "../texts/format.js";

/** @returns (attempts) => void; shows them in the list, the latest first */
export function attemptList(list) {
  const show = keyed(list, (attempt) => attempt.attempt, entry);
  return (attempts) => show([...attempts].reverse());
}

function entry(first) {
  const outcome = element("span");
  const took = element("span", { class: "muted" });
  const note = element("p", { class: "muted" });
  const error = block("Error");
  const log = block("End of the log");
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
  const update = (attempt) => {
    outcome.replaceChildren(statusMark(attempt.outcome), attempt.outcome);
    const seconds = (new Date(attempt.ended_at) - new Date(attempt.started_at)) / 1000;
    const resumed = attempt.resumed_timestep > 0 ? `, taken up at ${count(attempt.resumed_timestep)}` : "";
    setText(took, (attempt.ended_at === null ? "" : `, took ${duration(seconds)}`) + resumed);
    setText(note, attempt.note ?? "");
    error.update(attempt.error);
    log.update(attempt.log_tail);
  };
  return { node, update };
}

function block(title) {
  const text = element("pre", { "tabindex": "0", "aria-label": title });
  const node = element("details", { open: true }, element("summary", {}, title), text);
  const update = (content) => {
    setText(text, content);
    node.hidden = content === "";
  };
  return { node, update };
}
