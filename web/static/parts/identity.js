/** Who a curve is: the same label, colour and dash in every panel, in the legend and the figures. */
import { algorithmColour, dashPattern } from "./palette.js";

/**
 * The entries of a request, in its order, shown or not: a curve is of one of them, and the entry's
 * label is its identity.
 *
 * @param entries [{ label, algorithm }]
 * @returns Map from label to { label, colour, dash }
 */
export function identities(entries) {
  const variants = new Map(); // of a colour: algorithms that others added may share one
  const known = new Map();
  for (const { label, algorithm } of entries) {
    const colour = algorithmColour(algorithm);
    const variant = variants.get(colour) ?? 0;
    variants.set(colour, variant + 1);
    known.set(label, { label, colour, dash: dashPattern(variant) });
  }
  return known;
}
