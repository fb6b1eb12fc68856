/** Ask before something is stopped for good. */
import { at, within } from "./element.js";

const dialog = at("confirm", HTMLDialogElement);

/**
 * Show the question in a modal dialog.
 *
 * @param {{ title: string, detail: string, yes: string, no: string }} texts
 * @returns {Promise<boolean>} whether the answer was yes; Escape means no
 */
export function confirm({ title, detail, yes, no }) {
  const texts = { title, detail, yes, no };
  for (const [name, text] of Object.entries(texts)) {
    within(dialog, `[data-text=${name}]`).textContent = text;
  }
  dialog.returnValue = "no";
  dialog.showModal();
  return new Promise((resolve) => {
    const answer = () => resolve(dialog.returnValue === "yes");
    dialog.addEventListener("close", answer, { once: true });
  });
}
