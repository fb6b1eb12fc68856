/** Which curves are shown: those that are not hidden, whose label has the words sought, the highest. */

/**
 * @import { SELECTION_FIELDS, View } from "../parts/view.js"
 *
 * @typedef {typeof SELECTION_FIELDS} Fields
 */

/**
 * The labels that are not shown, for whichever reason.
 *
 * @param {Api.Panel[]} panels
 * @param {View<Fields>} view
 * @returns {Set<string>}
 */
export function hiddenLabels(panels, view) {
  const words = view.get("match").toLowerCase().split(/\s+/).filter(Boolean);
  const labels = [...new Set(panels.flatMap((panel) => panel.curves.map(({ label }) => label)))];
  const hidden = new Set(view.get("hide"));
  for (const label of labels) {
    if (!words.every((word) => label.toLowerCase().includes(word))) hidden.add(label);
  }
  const top = view.get("top");
  if (top === 0) return hidden;
  const rivals = labels.filter((label) => !hidden.has(label));
  const ranks = meanRanks(panels, rivals);
  const ranked = rivals.toSorted((a, b) => (ranks.get(a) ?? Infinity) - (ranks.get(b) ?? Infinity));
  return new Set([...hidden, ...ranked.slice(top)]);
}

/**
 * The mean, over the tasks, of each curve's place among the others by its latest value: tasks have
 * units of their own.
 *
 * @param {Api.Panel[]} panels
 * @param {string[]} labels
 * @returns {Map<string, number>}
 */
function meanRanks(panels, labels) {
  /** @type {Map<string, number[]>} */
  const places = new Map(labels.map((label) => [label, []]));
  for (const { curves } of panels) {
    const standing = curves
      .filter(({ label }) => places.has(label))
      .map(({ label, mean }) => ({ label, value: latest(mean) }))
      .toSorted((a, b) => b.value - a.value);
    standing.forEach(({ label }, place) => places.get(label)?.push(place));
  }
  return new Map(
    [...places].map(([label, own]) => [label, own.reduce((a, b) => a + b, 0) / (own.length || NaN)]),
  );
}

/**
 * The last value that there is; -Infinity without any.
 *
 * @param {(number | null)[]} values
 * @returns {number}
 */
export function latest(values) {
  return values.findLast((value) => value !== null) ?? -Infinity;
}
