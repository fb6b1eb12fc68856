/** What the masthead and the banner say about the connection to the service. */
import { at, element, setText } from "../parts/element.js";
import { timeOfDay } from "../texts/format.js";
import { here, thisPath } from "../texts/place.js";
import { Refusal } from "./api.js";

const state = at("connection");
const banner = at("banner");
const CAUGHT_UP_MILLISECONDS = 4000;
const NOT_FOUND = 404;

/** @type {Date | null} */
let lostAt = null; // since when what is shown may be old; null while it is not
let trouble = false; // whether the banner shows an error of a fetch
let isSignedOut = false;
let lacking = ""; // what the service says it lacks: a disk with space, a cluster
/** @type {ReturnType<typeof setTimeout> | undefined} */
let hiding = 0;

/** The stream broke: say so at once, and from when the figures on the page are. */
export function lost() {
  if (isSignedOut) return;
  lostAt ??= new Date();
  show("lost", "Offline");
  say(
    `Connection to the service lost at ${timeOfDay(lostAt)}. ` +
      "The page shows the state at that time. Reconnecting …",
  );
}

/** The stream is open; whether the page has caught up is told by `fresh`. */
export function live() {
  isSignedOut = false;
  show("live", "Live");
}

/** The service does not know this browser any more: its token is another one. */
export function signedOut() {
  isSignedOut = true;
  lostAt ??= new Date();
  show("lost", "Signed out");
  const wanted = new URLSearchParams({ next: thisPath() });
  const link = element("a", { href: here(`/signin?${wanted}`) }, "Sign in");
  say("This browser is not signed in any more. ", link, ".");
}

/** Everything on the page was just fetched. */
export function fresh() {
  if (state.dataset.state !== "live") return;
  if (lostAt !== null) {
    say(`Connected again. The page shows all changes since ${timeOfDay(lostAt)}.`);
    hiding = setTimeout(settle, CAUGHT_UP_MILLISECONDS);
  } else if (trouble) {
    settle();
  }
  lostAt = null;
  trouble = false;
}

/**
 * A fetch failed. While the connection is lost that is no news.
 *
 * @param {Error} error
 */
export function failed(error) {
  if (error instanceof Refusal && error.status === 401) signedOut();
  if (lostAt !== null) return;
  if (error instanceof Refusal && error.isFinal) refusedToShow(error);
  else {
    trouble = true;
    say(`${error.message} Trying again …`);
  }
}

/**
 * What the address asks for cannot be had: said where it would be, for as long as it is asked for.
 *
 * @param {Refusal} refusal
 */
function refusedToShow({ status, message }) {
  if (status === NOT_FOUND) return; // which the page itself says
  const place = at("loading");
  setText(place, `${message} Choose something else above, or reset the view.`);
  place.hidden = false;
}

/**
 * The service would not do what a person asked; nothing is tried again.
 *
 * @param {Error} refusal
 */
export function refused(refusal) {
  trouble = true;
  say(refusal.message);
}

/**
 * The service says what it lacks, or with an empty text that it lacks nothing.
 *
 * @param {string} problem
 */
export function lacks(problem) {
  if (problem === lacking) return;
  lacking = problem;
  if (lostAt === null && !trouble) settle();
}

/** Say what there still is to say. */
function settle() {
  if (lacking) say(lacking);
  else banner.hidden = true;
}

/**
 * @param {string} name
 * @param {string} text
 */
function show(name, text) {
  state.dataset.state = name;
  setText(state, text);
}

/** @param {(string | Node)[]} parts */
function say(...parts) {
  clearTimeout(hiding);
  banner.hidden = false;
  const text = element("span", {}, ...parts);
  if (banner.textContent !== text.textContent) banner.replaceChildren(...text.childNodes);
}
