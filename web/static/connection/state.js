/** What the masthead and the banner say about the connection to the service. */
import { at, setText } from "../parts/element.js";
import { timeOfDay } from "../texts/format.js";

const state = at("connection");
const banner = at("banner");
const CAUGHT_UP_MILLISECONDS = 4000;

/** @type {Date | null} */
let lostAt = null; // since when what is shown may be old; null while it is not
let trouble = false; // whether the banner shows an error of a fetch
let lacking = ""; // what the service says it lacks: a disk with space, a cluster
/** @type {ReturnType<typeof setTimeout> | undefined} */
let hiding = 0;

/** The stream broke: say so at once, and from when the figures on the page are. */
export function lost() {
  lostAt ??= new Date();
  show("lost", "Offline");
  say(
    `Connection to the service lost at ${timeOfDay(lostAt)}. ` +
      "What you see is from then. Reconnecting …",
  );
}

/** The stream is open; whether the page has caught up is told by `fresh`. */
export function live() {
  show("live", "Live");
}

/** Everything on the page was just fetched. */
export function fresh() {
  if (state.dataset.state !== "live") return;
  if (lostAt !== null) {
    say(`Connected again. Everything since ${timeOfDay(lostAt)} is here.`);
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
  if (lostAt !== null) return;
  trouble = true;
  say(`${error.message} Trying again …`);
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

/** @param {string} text */
function say(text) {
  clearTimeout(hiding);
  setText(banner, text);
  banner.hidden = false;
}
