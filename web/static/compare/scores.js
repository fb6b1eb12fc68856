/** What the entries of all compared sweeps reached, in one table. */
import { get } from "../connection/api.js";
import { at, element, setText } from "../parts/element.js";
import { identities } from "../parts/identity.js";
import { bodyRow } from "../sweep/scores.js";
import { here } from "../texts/place.js";
import { labelled, overlaidEntries } from "./compared.js";

/**
 * @import { Field, View } from "../parts/view.js"
 * @import { Compared } from "./compared.js"
 *
 * @typedef {object} Fields
 * @property {Field<"final" | "return_history" | "area">} score
 * @property {Field<"normalized" | "raw">} scale
 *
 * @typedef {Api.ScoreTable["rows"][number]} Row
 */

/**
 * Fetch the tables of the sweeps and show them as one; runs have none.
 *
 * @param {Compared[]} compared
 * @param {View<Fields>} view
 * @param {AbortSignal} signal
 */
export async function showScores(compared, view, signal) {
  const sweeps = compared.filter(({ page }) => page.startsWith(here("/sweeps/")));
  const asked = { score: view.get("score"), normalized: view.get("scale") === "normalized" };
  const tables = await Promise.all(
    sweeps.map(({ id }) => get(`/sweeps/${id}/table`, asked, signal)),
  );
  at("scores").hidden = tables.length === 0;
  if (tables.length === 0) return;
  const environments = [...new Set(tables.flatMap((table) => table.environments))];
  const decimals = Math.max(...tables.map((table) => table.decimals));
  const rows = tables.flatMap((table, i) =>
    table.rows.map((row) => labelled(placed(row, table, environments), sweeps[i], compared)),
  );
  const known = identities(overlaidEntries(compared));
  const heads = ["Learner", ...environments].map((name) =>
    element("th", { scope: "col", class: name === "Learner" ? null : "number" }, name),
  );
  at("score-table").replaceChildren(
    element("thead", {}, element("tr", {}, ...heads)),
    element("tbody", {}, ...withBest(rows).map((row) => bodyRow(row, decimals, known))),
  );
  setText(at("score-definition"), tables[0].definition);
}

/**
 * A row of a table under other columns.
 *
 * @param {Row} row
 * @param {Api.ScoreTable} table
 * @param {string[]} environments
 * @returns {Row}
 */
function placed(row, table, environments) {
  const entries = environments.map((name) => row.entries[table.environments.indexOf(name)] ?? null);
  return { ...row, entries };
}

/**
 * Rows in which only the best of all sweeps is marked, of those that were the best of their own.
 *
 * @param {Row[]} rows
 * @returns {Row[]}
 */
function withBest(rows) {
  const columns = rows[0]?.entries.map((_, i) => {
    const means = rows.flatMap(({ entries }) => (entries[i]?.is_best ? [entries[i].mean] : []));
    return Math.max(...means.map((mean) => mean ?? -Infinity));
  });
  return rows.map((row) => ({
    ...row,
    entries: row.entries.map((entry, i) => {
      return entry && { ...entry, is_best: entry.is_best && entry.mean === columns[i] };
    }),
  }));
}
