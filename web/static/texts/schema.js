/** An algorithm's settings, out of the JSON schema of its config. */

/** @returns [{ name, kind, initial, text }]; kind as a person says it */
export function settings(schema) {
  return Object.entries(schema.properties ?? {}).map(([name, property]) => ({
    name,
    kind: kindText(property),
    initial: property.default,
    text: property.description ?? "",
    choices: property.enum ?? null,
  }));
}

function kindText(property) {
  const { type, enum: choices, anyOf, items } = property;
  if (choices) return choices.join(" or ");
  if (anyOf) return anyOf.map(kindText).join(" or ");
  if (type === "array") return items ? `list of ${kindText(items)}s` : "list";
  const named = { integer: "whole number", number: "number", boolean: "yes or no", string: "text" };
  return (named[type] ?? type ?? "value") + limitsText(property);
}

function limitsText({ minimum, exclusiveMinimum, maximum, exclusiveMaximum }) {
  const limits = [
    minimum !== undefined && `≥ ${minimum}`,
    exclusiveMinimum !== undefined && `> ${exclusiveMinimum}`,
    maximum !== undefined && `≤ ${maximum}`,
    exclusiveMaximum !== undefined && `< ${exclusiveMaximum}`,
  ].filter(Boolean);
  return limits.length > 0 ? ` ${limits.join(", ")}` : "";
}
