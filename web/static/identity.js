/** Who a curve is: the same label, colour and dash in every panel, in the legend and the figures. */
import { algorithmColour, dashPattern } from "./palette.js";

/**
 * The curves of a sweep over all of its panels, in the order in which they were submitted. The
 * service labels a curve by its algorithm and what tells it from its neighbours, so the label is
 * its identity; weights that only differ from task to task are the same curve.
 *
 * @returns Map from label to { label, colour, dash, runs }; `runs` counts those of all panels
 */
export function identities(panels) {
  const known = new Map();
  const variants = new Map();
  for (const { label, algorithm, runs } of panels.flatMap((panel) => panel.curves)) {
    if (!known.has(label)) {
      const variant = variants.get(algorithm) ?? 0;
      variants.set(algorithm, variant + 1);
      const dash = dashPattern(variant);
      known.set(label, { label, colour: algorithmColour(algorithm), dash, runs: 0 });
    }
    known.get(label).runs += runs;
  }
  return known;
}
