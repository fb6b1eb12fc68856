/** How a sweep is described: its tags and notes, and the form that changes them. */
import { patch, refusalOf } from "../connection/api.js";
import { at, element, field, setText, within } from "../parts/element.js";
import { clearFaults, showFaults } from "../parts/faults.js";

export class Description {
  #form = at("edit", HTMLFormElement);
  #opener = at("describe", HTMLButtonElement);
  #refetch;
  /** @type {Api.Sweep | null} */
  #sweep = null;

  /** @param {() => void} refetch the sweep was changed */
  constructor(refetch) {
    this.#refetch = refetch;
    this.#opener.addEventListener("click", () => this.#open(this.#form.hidden));
    within(this.#form, "[name=close]").addEventListener("click", () => this.#open(false));
    this.#form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#save();
    });
  }

  /** @param {Api.Sweep} sweep */
  show(sweep) {
    this.#sweep = sweep;
    this.#opener.hidden = false;
    const tags = [...sweep.tags, ...(sweep.archived ? ["archived"] : [])];
    const shown = tags.map((tag) => element("span", { class: "tag" }, tag));
    at("tags").replaceChildren(...shown);
    setText(at("notes"), sweep.notes);
    at("description").hidden = tags.length === 0 && sweep.notes === "";
  }

  /** @param {boolean} isOpen */
  #open(isOpen) {
    if (this.#sweep === null) return;
    this.#form.hidden = !isOpen;
    this.#opener.setAttribute("aria-expanded", String(isOpen));
    if (!isOpen) {
      this.#opener.focus();
      return;
    }
    this.#complain([], "");
    this.#input("name").value = this.#sweep.name;
    this.#input("tags").value = this.#sweep.tags.join(", ");
    this.#input("priority").value = String(this.#sweep.priority);
    this.#input("archived").checked = this.#sweep.archived;
    field(this.#form, "notes", HTMLTextAreaElement).value = this.#sweep.notes;
    this.#input("name").focus();
  }

  async #save() {
    const tags = this.#input("tags").value.split(",").map((tag) => tag.trim());
    const priority = this.#input("priority").value.trim();
    const changes = {
      name: this.#input("name").value,
      tags: tags.filter(Boolean),
      priority: Number.isNaN(Number(priority)) ? priority : Number(priority),
      archived: this.#input("archived").checked,
      notes: field(this.#form, "notes", HTMLTextAreaElement).value,
    };
    try {
      await patch(`/sweeps/${this.#sweep?.id}`, changes);
      this.#open(false);
      this.#refetch();
    } catch (error) {
      const { message, errors } = refusalOf(error);
      this.#complain(errors, message);
    }
  }

  /**
   * @param {Api.Fault[]} errors
   * @param {string} message
   */
  #complain(errors, message) {
    clearFaults(this.#form);
    /** @type {[string, Element][]} */
    const places = [...this.#form.querySelectorAll("[data-fault]")].map((node) => {
      return [node.getAttribute("data-fault") ?? "", node];
    });
    const homeless = showFaults(errors, places);
    const rest = errors.length > 0 ? homeless.join(" ") : message;
    setText(at("edit-fault"), rest);
    at("edit-fault").hidden = rest === "";
  }

  /**
   * @param {string} name
   * @returns {HTMLInputElement}
   */
  #input(name) {
    return field(this.#form, name, HTMLInputElement);
  }
}
