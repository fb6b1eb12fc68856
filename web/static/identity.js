/** Who a curve is: the same label, colour and dash in every panel, in the legend and the figures. */
import { algorithmColour, dashPattern } from "./palette.js";

/**
 * The curves of a sweep over all of its panels, in the order in which they were submitted. A curve is
 * of an entry of the sweep's request, and the entry's label is its identity.
 *
 * @returns Map from label to { label, colour, dash, runs }; `runs` counts those of all panels
 */
export function identities(panels) {
  const known = new Map();
  const variants = new Map();
  for (const { label, algorithm, runs } of panels.flatMap((panel) => panel.curves)) {
    if (!known.has(label)) {
      const colour = algorithmColour(algorithm);
      const variant = variants.get(colour) ?? 0; // algorithms that others added may share one
      variants.set(colour, variant + 1);
      known.set(label, { label, colour, dash: dashPattern(variant), runs: 0 });
    }
    known.get(label).runs += runs;
  }
  return known;
}
