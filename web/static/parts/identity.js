/** Who a curve is: the same label, colour and dash in every panel, in the legend and the figures. */
import { algorithmColour, dashPattern } from "./palette.js";

/** @typedef {{ label: string, colour: string, dash: number[] }} Identity */
/** @typedef {Map<string, Identity>} Identities by label */

/**
 * The entries of a request, in its order, shown or not: a curve is of one of them, and the entry's
 * label is its identity.
 *
 * @param {{ label: string, algorithm: string }[]} entries [{ label, algorithm }]
 * @returns {Identities} Map from label to { label, colour, dash }
 */
export function identities(entries) {
  /** @type {Map<string, number>} */
  const variants = new Map(); // of a colour: algorithms that others added may share one
  /** @type {Identities} */
  const known = new Map();
  for (const { label, algorithm } of entries) {
    const colour = algorithmColour(algorithm);
    const variant = variants.get(colour) ?? 0;
    variants.set(colour, variant + 1);
    known.set(label, { label, colour, dash: dashPattern(variant) });
  }
  return known;
}

/**
 * @param {Identities} known
 * @param {string} label of one of the entries
 * @returns {Identity}
 */
export function identityOf(known, label) {
  const identity = known.get(label);
  if (identity === undefined) throw new Error(`No entry is called ${label}.`);
  return identity;
}
