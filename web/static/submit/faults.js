/** What the service finds wrong with a form, each beside its field. */
import { element } from "../parts/element.js";

/** Take all of them away. */
export function clearFaults(form) {
  for (const fault of form.querySelectorAll("[data-shown-fault]")) fault.remove();
  for (const input of form.querySelectorAll("[aria-invalid]")) input.removeAttribute("aria-invalid");
}

/**
 * Show faults.
 *
 * @param errors [{ field, message }]
 * @param places [[field, node]]: where a fault of a field, or of a part of it, belongs; the first
 *   one that fits
 * @returns the messages that belong nowhere
 */
export function showFaults(errors, places) {
  const homeless = [];
  for (const { field, message } of errors) {
    const place = places.find(([name]) => field === name || /^[.[]/.test(field.slice(name.length)) && field.startsWith(name));
    if (place === undefined) homeless.push(`${field}: ${message}`);
    else place[1].append(element("p", { "class": "fault", "data-shown-fault": "" }, message));
    place?.[1].querySelector(":scope > input")?.setAttribute("aria-invalid", "true");
  }
  return homeless;
}
