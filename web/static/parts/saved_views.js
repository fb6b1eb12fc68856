/**
 * Views that a person keeps by name. They lie in this browser: a view is a habit of whoever looks,
 * the service need not know who that is, and a link shares one with others.
 */
import { at, element, setText } from "./element.js";

/** @import { View } from "./view.js" */

const STORAGE = "d3pg.views";
const LONGEST_NAME = 60;

export class SavedViews {
  #view;
  #fields;
  #choice = at("saved-views", HTMLSelectElement);
  #name = at("view-name", HTMLInputElement);
  #forget = at("forget-view", HTMLButtonElement);

  /**
   * @param {View<any>} view
   * @param {readonly string[]} fields those that are kept
   */
  constructor(view, fields) {
    this.#view = view;
    this.#fields = fields;
    this.#choice.addEventListener("change", () => this.#show(this.#choice.value));
    at("save-view", HTMLFormElement).addEventListener("submit", (event) => {
      event.preventDefault();
      this.#save(this.#name.value.trim());
    });
    this.#forget.addEventListener("click", () => this.#drop(this.#choice.value));
    window.addEventListener("storage", () => this.#offer());
    view.onChange(() => this.#offer());
    this.#offer();
  }

  get #now() {
    return JSON.stringify(Object.fromEntries(this.#fields.map((field) => [field, this.#view.get(field)])));
  }

  /** Offer what is kept; the one that is shown is chosen. */
  #offer() {
    const kept = read();
    const names = Object.keys(kept).toSorted((a, b) => a.localeCompare(b));
    const shown = names.find((name) => JSON.stringify(kept[name]) === this.#now) ?? "";
    const options = names.map((name) => element("option", { value: name }, name));
    this.#choice.replaceChildren(element("option", { value: "" }, "Saved views"), ...options);
    this.#choice.value = shown;
    this.#choice.hidden = names.length === 0;
    this.#forget.hidden = shown === "";
  }

  /** @param {string} name */
  #show(name) {
    const kept = read()[name];
    if (kept !== undefined) this.#view.set(kept);
  }

  /** @param {string} name */
  #save(name) {
    if (name === "") return;
    const isKept = write({ ...read(), [name.slice(0, LONGEST_NAME)]: JSON.parse(this.#now) });
    setText(at("view-state"), isKept ? `Saved “${name}” in this browser.` : "This browser stores no views.");
    if (isKept) this.#name.value = "";
    this.#offer();
  }

  /** @param {string} name */
  #drop(name) {
    const { [name]: _, ...rest } = read();
    write(rest);
    setText(at("view-state"), `Removed “${name}”; the list stays as it is.`);
    this.#offer();
    this.#name.focus();
  }
}

/**
 * @returns {Record<string, Record<string, any>>} values of fields by the name of their view
 */
function read() {
  try {
    const kept = JSON.parse(localStorage.getItem(STORAGE) ?? "{}");
    return kept !== null && typeof kept === "object" ? kept : {};
  } catch {
    return {}; // storage is switched off, or holds something else
  }
}

/**
 * @param {Record<string, Record<string, any>>} views
 * @returns {boolean} whether they are kept
 */
function write(views) {
  try {
    localStorage.setItem(STORAGE, JSON.stringify(views));
    return true;
  } catch {
    return false;
  }
}
