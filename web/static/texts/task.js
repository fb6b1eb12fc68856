/** Tasks in words: `Pendulum(gravity=9.81)` is the task Pendulum with one parameter given. */
import { number } from "./format.js";

/**
 * The name of a task, without the values of its parameters.
 *
 * @param {string} environment
 * @returns {string}
 */
export function taskName(environment) {
  return environment.split("(")[0];
}

/**
 * The values that are given of its parameters, by name.
 *
 * @param {string} environment
 * @returns {Map<string, number>}
 */
export function givenValues(environment) {
  const inside = environment.match(/\((.*)\)$/)?.[1] ?? "";
  const pairs = inside.split(", ").filter(Boolean);
  return new Map(
    pairs.map((pair) => {
      const [name, value] = pair.split("=");
      return [name, Number(value)];
    }),
  );
}

/**
 * "9.81 m/s^2".
 *
 * @param {number} value
 * @param {{ unit: string }} parameter
 * @returns {string}
 */
export function quantity(value, { unit }) {
  return unit === "1" ? number(value) : `${number(value)} ${unit}`;
}
