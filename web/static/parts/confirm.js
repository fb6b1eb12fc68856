/** Ask before something is stopped for good. */

const dialog = document.getElementById("confirm");

/**
 * Show the question in a modal dialog.
 *
 * @param texts { title, detail, yes, no }
 * @returns Promise of whether the answer was yes; Escape means no
 */
export function confirm({ title, detail, yes, no }) {
  const texts = { title, detail, yes, no };
  for (const [name, text] of Object.entries(texts)) {
    dialog.querySelector(`[data-text=${name}]`).textContent = text;
  }
  dialog.returnValue = "no";
  dialog.showModal();
  return new Promise((resolve) => {
    const answer = () => resolve(dialog.returnValue === "yes");
    dialog.addEventListener("close", answer, { once: true });
  });
}
