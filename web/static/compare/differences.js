/** Settings side by side: a row per setting, a column per thing compared. */
import { element } from "../parts/element.js";

/** @import { Compared } from "./compared.js" */

/**
 * Fill the table.
 *
 * @param {HTMLElement} table
 * @param {Compared[]} compared
 * @param {boolean} withSame whether settings that all agree in are shown too
 * @returns {number} how many settings differ
 */
export function fillDifferences(table, compared, withSame) {
  const columns = compared.map(({ settings }) => new Map(settings));
  const names = [...new Set(columns.flatMap((column) => [...column.keys()]))];
  const rows = names.map((name) => {
    const texts = columns.map((column) => column.get(name) ?? "–");
    return { name, texts, differs: texts.some((text) => text !== texts[0]) };
  });
  const heads = compared.map(({ name, page }) =>
    element("th", { scope: "col" }, element("a", { href: page }, name)),
  );
  table.replaceChildren(
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Setting"), ...heads)),
    element("tbody", {}, ...rows.filter(({ differs }) => differs || withSame).map(tableRow)),
  );
  return rows.filter(({ differs }) => differs).length;
}

/**
 * @param {{ name: string, texts: string[], differs: boolean }} row
 * @returns {HTMLElement}
 */
function tableRow({ name, texts, differs }) {
  return element(
    "tr",
    { class: differs ? "differs" : null },
    element("th", { scope: "row" }, name),
    ...texts.map((text) => element("td", {}, text)),
  );
}
