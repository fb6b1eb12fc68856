/** Named values as a description list; nested ones by their path. */
import { number } from "../texts/format.js";
import { element } from "./element.js";

/**
 * @param {HTMLElement} list
 * @param {object} facts
 */
export function showFacts(list, facts) {
  const rows = flat(facts).map(([name, value]) =>
    element("div", {}, element("dt", {}, name), element("dd", {}, value)),
  );
  const shown = rows.map((row) => row.textContent).join("\n");
  if (list.dataset.shown === shown) return;
  list.dataset.shown = shown;
  list.replaceChildren(...rows);
}

/**
 * [path, text] of every leaf.
 *
 * @param {object | null} facts
 * @param {string} [prefix]
 * @returns {[path: string, text: string][]}
 */
export function flat(facts, prefix = "") {
  return Object.entries(facts ?? {}).flatMap(([name, value]) => {
    const path = prefix + name;
    const isGroup = value !== null && typeof value === "object" && !Array.isArray(value);
    return isGroup ? flat(value, `${path}.`) : [[path, factText(value)]];
  });
}

/**
 * @param {unknown} value
 * @returns {string}
 */
function factText(value) {
  if (Array.isArray(value)) return value.map(factText).join(", ");
  return typeof value === "number" && !Number.isInteger(value) ? number(value) : String(value);
}
