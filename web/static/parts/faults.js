/** What the service finds wrong with a form, each beside its field. */
import { element } from "./element.js";

/**
 * Take all of them away.
 *
 * @param {HTMLFormElement} form
 */
export function clearFaults(form) {
  for (const fault of form.querySelectorAll("[data-shown-fault]")) fault.remove();
  for (const input of form.querySelectorAll("[aria-invalid]")) input.removeAttribute("aria-invalid");
}

/** @typedef {[field: string, node: Element]} Place */

/**
 * Show faults.
 *
 * @param {Api.Fault[]} errors
 * @param {Place[]} places where a fault of a field, or of a part of it, belongs; the first one that
 *   fits
 * @returns {string[]} the messages that belong nowhere
 */
export function showFaults(errors, places) {
  /** @type {string[]} */
  const homeless = [];
  for (const { field, message } of errors) {
    const place = places.find(([name]) => isPartOf(field, name));
    if (place === undefined) homeless.push(`${field}: ${message}`);
    else place[1].append(element("p", { "class": "fault", "data-shown-fault": "" }, message));
    place?.[1].querySelector(":scope > input")?.setAttribute("aria-invalid", "true");
  }
  return homeless;
}

/**
 * Whether a field is another or lies within it: `algorithms[0].weights` in `algorithms[0]`.
 *
 * @param {string} field
 * @param {string} whole
 * @returns {boolean}
 */
function isPartOf(field, whole) {
  return field === whole || [".", "["].some((mark) => field.startsWith(whole + mark));
}
