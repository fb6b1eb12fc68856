/** Who a curve is: the same label, colour and dash in every panel, in the legend and the figures. */
import { algorithmColour, dashPattern, shades } from "./palette.js";

/**
 * @typedef {object} Entry
 * @property {string} label
 * @property {string} algorithm
 * @property {Record<string, unknown>} [stated]   weights and settings that it states
 */
/** @typedef {{ label: string, colour: string, dash: number[] }} Identity */
/** @typedef {Map<string, Identity>} Identities by label */

/**
 * The entries of a request, in its order, shown or not: a curve is of one of them, and the entry's
 * label is its identity. Entries of one colour are its shades, by the value where they differ in one
 * number alone, else in the order of the request.
 *
 * @param {Entry[]} entries
 * @returns {Identities}
 */
export function identities(entries) {
  /** @type {Map<string, Entry[]>} */
  const siblings = new Map(); // by colour: algorithms that others added may share one
  for (const entry of entries) {
    const colour = algorithmColour(entry.algorithm);
    siblings.set(colour, [...(siblings.get(colour) ?? []), entry]);
  }
  /** @type {Identities} */
  const looks = new Map();
  for (const [colour, group] of siblings) {
    const tints = shades(colour, group.length);
    const ordered = byValue(group);
    group.forEach((entry, i) => {
      const { label } = entry;
      looks.set(label, { label, colour: tints[ordered.indexOf(entry)], dash: dashPattern(i) });
    });
  }
  return new Map(entries.map(({ label }) => [label, identityOf(looks, label)]));
}

/**
 * Entries by the one number in which they differ, the smallest first; as they are where they differ
 * in something else.
 *
 * @param {Entry[]} entries
 * @returns {Entry[]}
 */
function byValue(entries) {
  const [name, ...others] = varied(entries);
  const value = (/** @type {Entry} */ { stated = {} }) => stated[name];
  const isOrdered = others.length === 0 && entries.every((each) => typeof value(each) === "number");
  return isOrdered ? entries.toSorted((a, b) => Number(value(a)) - Number(value(b))) : entries;
}

/**
 * The names of what entries state differently, in the order in which they state it.
 *
 * @param {Entry[]} entries
 * @returns {string[]}
 */
export function varied(entries) {
  const names = new Set(entries.flatMap(({ stated = {} }) => Object.keys(stated)));
  return [...names].filter((name) => {
    return new Set(entries.map(({ stated = {} }) => JSON.stringify(stated[name]))).size > 1;
  });
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
