/** A diagnosis of a run or of the runs of a sweep, in words. */
import { counted } from "./format.js";

/**
 * What the button that asks for it says; empty where there is nothing to ask for.
 *
 * @param {Api.Diagnosis} diagnosis
 * @returns {string}
 */
export function askingOf({ runs, waiting, done, failed }) {
  const fresh = runs - waiting - done - failed;
  if (waiting > 0) return "";
  if (fresh > 0) return done > 0 ? `Diagnose ${counted(fresh, "more run")}` : "Diagnose";
  return failed > 0 ? "Try again" : "";
}

/**
 * How far it is.
 *
 * @param {Api.Diagnosis} diagnosis
 * @returns {string}
 */
export function stateText({ runs, waiting, done, failed }) {
  if (runs === 0) return "A diagnosis needs a run that has reached its end.";
  const ended = done + failed;
  if (waiting > 0) return `${ended} of ${counted(runs, "run")} diagnosed …`;
  if (ended === 0) {
    const subject = runs === 1 ? "the run" : `each of ${counted(runs, "run")}`;
    return (
      "Bias, variance and growth of exact gradients along episodes of what " +
      `${subject} has learned; it takes some seconds a run.`
    );
  }
  return done > 0 ? `${counted(done, "run")} diagnosed.` : "";
}
