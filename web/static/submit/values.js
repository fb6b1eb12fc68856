/** The values of a form's fields as text, and back: numbers, lists that are grids, pairs of weights. */

/**
 * What presets say in some environments: one value, or each with its environment.
 *
 * @param {{ name: string, text: string }[]} values
 * @param {string} usual what is said without any environment
 * @returns {string}
 */
export function presetText(values, usual) {
  const texts = [...new Set(values.map(({ text }) => text))];
  if (texts.length < 2) return texts[0] ?? usual;
  const where = (/** @type {string} */ text) => values.filter((each) => each.text === text);
  const parts = texts.map((text) => `${text} in ${where(text).map(({ name }) => name).join(", ")}`);
  return parts.join("; ");
}

/**
 * @param {unknown} value
 * @returns {string}
 */
export function settingText(value) {
  return value === undefined || value === null ? "" : JSON.stringify(value).replaceAll('"', "");
}

/**
 * "0.1, 0.1; 0.01, 0" as the request has it; what is no number is for the service to refuse.
 *
 * @param {string} text
 * @returns {object | null}
 */
export function readWeights(text) {
  const pairs = text.split(";").map((pair) => pair.trim());
  const read = pairs.filter(Boolean).map((pair) => {
    const [w1, w2] = asList(pair) ?? pair.split(",").map((each) => each.trim());
    return { w1, ...(w2 === undefined ? {} : { w2 }) };
  });
  if (read.length === 0) return null;
  return read.length === 1 ? read[0] : read;
}

/**
 * @param {Api.AlgorithmRequest["weights"]} weights
 * @returns {string}
 */
export function writeWeights(weights) {
  if (weights === undefined || weights === null) return "";
  const text = (/** @type {number | number[]} */ value) => JSON.stringify(value).replaceAll(",", ", ");
  return [weights].flat().map(({ w1 = 0, w2 = 0 }) => `${text(w1)}, ${text(w2)}`).join("; ");
}

/**
 * A number, truth value or list where the text is one, else the text; several with commas between
 * them are a list.
 *
 * @param {string} text
 * @returns {unknown}
 */
export function readSetting(text) {
  const values = asList(text);
  if (values === null) return text;
  return values.length === 1 ? values[0] : values;
}

/**
 * The values between commas, where each is one of JSON or a number that Python reads too.
 *
 * @param {string} text
 * @returns {unknown[] | null}
 */
function asList(text) {
  try {
    return JSON.parse(`[${text.replaceAll("−", "-")}]`);
  } catch {
    return null;
  }
}

/**
 * @param {unknown} value
 * @returns {string}
 */
export function writeSetting(value) {
  if (!Array.isArray(value)) return JSON.stringify(value).replaceAll(/^"|"$/g, "");
  return value.map((each) => JSON.stringify(each)).join(", ");
}
