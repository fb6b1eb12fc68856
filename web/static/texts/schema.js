/** An algorithm's settings, out of the JSON schema of its config. */

/**
 * What is read of a JSON schema.
 *
 * @typedef {object} Schema
 * @property {Record<string, Schema>} [properties]
 * @property {string} [type]
 * @property {unknown[]} [enum]
 * @property {Schema[]} [anyOf]
 * @property {Schema} [items]
 * @property {unknown} [default]
 * @property {string} [description]
 * @property {number} [minimum]
 * @property {number} [exclusiveMinimum]
 * @property {number} [maximum]
 * @property {number} [exclusiveMaximum]
 *
 * @typedef {{ name: string, kind: string, initial: unknown }} Setting   kind: as a person says it
 */

const KINDS = new Map([
  ["integer", "whole number"],
  ["number", "number"],
  ["boolean", "yes or no"],
  ["string", "text"],
]);

/**
 * @param {Schema} schema
 * @returns {Setting[]}
 */
export function settings(schema) {
  return Object.entries(schema.properties ?? {}).map(([name, property]) => ({
    name,
    kind: kindText(property),
    initial: property.default,
  }));
}

/**
 * @param {Schema} property
 * @returns {string}
 */
function kindText(property) {
  const { type, enum: choices, anyOf, items } = property;
  if (choices) return choices.join(" or ");
  if (anyOf) return anyOf.map(kindText).join(" or ");
  if (type === "array") return items ? `list of ${kindText(items)}s` : "list";
  return (KINDS.get(type ?? "") ?? type ?? "value") + limitsText(property);
}

/**
 * @param {Schema} property
 * @returns {string}
 */
function limitsText({ minimum, exclusiveMinimum, maximum, exclusiveMaximum }) {
  const limits = [
    minimum !== undefined && `≥ ${minimum}`,
    exclusiveMinimum !== undefined && `> ${exclusiveMinimum}`,
    maximum !== undefined && `≤ ${maximum}`,
    exclusiveMaximum !== undefined && `< ${exclusiveMaximum}`,
  ].filter(Boolean);
  return limits.length > 0 ? ` ${limits.join(", ")}` : "";
}
