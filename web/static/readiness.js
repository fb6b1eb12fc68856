/** Asks the service now and then what it lacks, for the banner: space on a disk, a cluster. */
import * as connection from "./connection.js";

const PERIOD_MILLISECONDS = 5000;

export function watch() {
  setTimeout(async () => {
    if (!document.hidden) connection.lacks(await problem());
    watch();
  }, PERIOD_MILLISECONDS);
}

/** The first sentence of `/readyz` that tells of something; that nobody answers is told elsewhere. */
async function problem() {
  try {
    const { checks } = await (await fetch("/readyz")).json();
    return checks.find((check) => check.problem)?.problem ?? "";
  } catch {
    return "";
  }
}
