/** Sharing what is on the page: a link by which anybody can read its sweeps, for some days. */
import { at, setText } from "../parts/element.js";
import { thisPath } from "../texts/place.js";
import { post, refusalOf, remove } from "./api.js";

/**
 * Offer it with the page's form for sharing.
 *
 * @param {() => string[]} sweeps the ids of those that the page shows
 */
export function offerSharing(sweeps) {
  const form = at("sharing", HTMLFormElement);
  const opener = at("share");
  opener.addEventListener("click", () => {
    form.hidden = !form.hidden;
    opener.setAttribute("aria-expanded", String(!form.hidden));
  });
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    told(() => make(sweeps()));
  });
  at("share-revoke").addEventListener("click", () => told(takeBack));
  at("share-copy").addEventListener("click", () => told(copy));
}

let made = ""; // the id of the share that is shown

/** @param {string[]} sweeps */
async function make(sweeps) {
  const days = Number(at("share-days", HTMLSelectElement).value);
  const share = await post("/shares", { sweeps, days, page: thisPath() });
  made = share.id;
  at("share-link", HTMLInputElement).value = share.link;
  at("share-made").hidden = false;
  const until = new Date(share.expires_at).toLocaleString();
  return `Anybody who has this link can read ${said(sweeps)} until ${until}. It is shown this once.`;
}

async function takeBack() {
  await remove(`/shares/${made}`);
  at("share-made").hidden = true;
  return "The link is revoked.";
}

async function copy() {
  await navigator.clipboard.writeText(at("share-link", HTMLInputElement).value);
  return "Copied.";
}

/**
 * @param {string[]} sweeps
 * @returns {string}
 */
function said(sweeps) {
  return sweeps.length === 1 ? "this sweep" : `these ${sweeps.length} sweeps, whole`;
}

/** @param {() => Promise<string>} work whose end, or the service's refusal, is told */
async function told(work) {
  const state = at("share-state");
  try {
    setText(state, await work());
  } catch (error) {
    setText(state, refusalOf(error).message);
  }
}
