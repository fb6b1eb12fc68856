/** The form that submits a sweep, made of the catalogue; its draft lives in the address. */
import { get, isDropped, post, refusalOf } from "../connection/api.js";
import { at, element, field, setText } from "../parts/element.js";
import { clearFaults, showFaults } from "../parts/faults.js";
import { here } from "../texts/place.js";
import { LearnerFields } from "./learner_fields.js";
import { estimateText, fillPlan } from "./plan.js";
import { readSetting } from "./values.js";

/**
 * @import { Field, View } from "../parts/view.js"
 *
 * @typedef {Api.Request} Draft
 */

const PAUSE_MILLISECONDS = 250; // after the last key, before the service is asked
const SHOWN = ["name", "algorithms", "environments", "seeds", "timesteps", "scale", "priority"];
const OPTIONAL = /** @type {const} */ (["timesteps", "scale", "priority"]); // numbers

export class Submission {
  #view;
  #form = at("submission-form", HTMLFormElement);
  #submitter = at("submit", HTMLButtonElement);
  /** @type {LearnerFields[]} */
  #learners = [];
  /** @type {HTMLInputElement[]} */
  #environments = [];
  #key = newKey();
  #sent = false;
  /** @type {Draft} */
  #carried = {}; // what a draft has beside the fields of the form: notes, tags, limits
  #added = 0; // items so far beyond an algorithm's first: their inputs have names of their own
  #asking = new AbortController();
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;

  /**
   * @param {View<{ new: Field<string> }>} view its field "new" is the draft as JSON, "" while the
   *   form is closed
   */
  constructor(view) {
    this.#view = view;
    at("new").addEventListener("click", () => this.#open("{}"));
    at("close").addEventListener("click", () => this.#close());
    this.#form.addEventListener("input", () => this.#onInput());
    this.#form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#submit();
    });
    if (view.get("new")) this.#open(view.get("new"));
  }

  /** @param {string} draft */
  async #open(draft) {
    this.#view.set({ new: draft });
    at("submission").hidden = false;
    at("new").setAttribute("aria-expanded", "true");
    try {
      if (this.#learners.length === 0) await this.#build();
    } catch (error) {
      this.#refused(refusalOf(error));
      return;
    }
    this.#fill(parsed(draft));
    this.#field("name").focus();
    this.#onInput();
  }

  #close() {
    this.#view.set({ new: "" });
    at("submission").hidden = true;
    at("new").setAttribute("aria-expanded", "false");
    at("new").focus();
  }

  async #build() {
    const { algorithms, environments } = await get("/catalogue");
    this.#learners = algorithms.map((algorithm) => this.#fields(algorithm, 0));
    this.#environments = environments.map(({ name }) =>
      element("input", { type: "checkbox", name: "environment", value: name }),
    );
    at("submission-algorithms").replaceChildren(...this.#learners.map(({ node }) => node));
    at("submission-environments").replaceChildren(
      ...this.#environments.map((box) =>
        element("div", { class: "option" }, element("label", {}, box, box.value)),
      ),
    );
  }

  /**
   * The inputs of an algorithm's first item, or of one more.
   *
   * @param {Api.Algorithm} algorithm
   * @param {number} place among those of the algorithm that were ever made
   * @returns {LearnerFields}
   */
  #fields(algorithm, place) {
    const made = new LearnerFields(algorithm, {
      place,
      onAnother: () => {
        this.#another(algorithm);
        this.#onInput();
      },
      onRemove: () => {
        this.#remove(made);
        this.#onInput();
      },
    });
    return made;
  }

  /**
   * One more item of an algorithm, after those that it has.
   *
   * @param {Api.Algorithm} algorithm
   * @returns {LearnerFields}
   */
  #another(algorithm) {
    const last = this.#learners.findLastIndex((each) => each.algorithm === algorithm);
    const added = this.#fields(algorithm, ++this.#added);
    this.#learners[last].node.after(added.node);
    this.#learners = this.#learners.toSpliced(last + 1, 0, added);
    return added;
  }

  /** @param {LearnerFields} learner */
  #remove(learner) {
    learner.node.remove();
    this.#learners = this.#learners.filter((each) => each !== learner);
  }

  /** @param {Draft} draft */
  #fill(draft) {
    const others = Object.entries(draft).filter(([name]) => !SHOWN.includes(name));
    this.#carried = Object.fromEntries(others);
    this.#field("name").value = draft.name ?? "";
    this.#field("seeds").value = [draft.seeds ?? 4].flat().join(", ");
    for (const name of OPTIONAL) this.#field(name).value = String(draft[name] ?? "");
    for (const learner of this.#learners.filter((each) => each.isAdded)) this.#remove(learner);
    for (const learner of this.#learners) {
      const { algorithm } = learner;
      const [first, ...more] = draft.algorithms?.filter(({ name }) => name === algorithm.name) ?? [];
      learner.fill(first);
      for (const request of more) this.#another(algorithm).fill(request);
    }
    for (const box of this.#environments) {
      box.checked = draft.environments?.includes(box.value) ?? false;
    }
  }

  /** What `POST /sweeps` takes. */
  #request() {
    const name = this.#field("name").value.trim();
    const environments = this.#chosenEnvironments;
    const listed = this.#field("seeds").value.split(",").map((each) => readSetting(each.trim()));
    const chosen = this.#learners.filter((learner) => learner.isChosen);
    const optional = OPTIONAL.map((each) => [each, this.#field(each).value.trim()]);
    return {
      ...this.#carried,
      ...(name ? { name } : {}),
      algorithms: chosen.map((learner) => learner.request(environments)),
      environments,
      seeds: listed.length === 1 ? listed[0] : listed,
      ...Object.fromEntries(
        optional.filter(([, text]) => text).map(([each, text]) => [each, readSetting(text)]),
      ),
    };
  }

  /**
   * @param {string} name
   * @returns {HTMLInputElement}
   */
  #field(name) {
    return field(this.#form, name, HTMLInputElement);
  }

  get #chosenEnvironments() {
    return this.#environments.filter((box) => box.checked).map((box) => box.value);
  }

  #onInput() {
    for (const learner of this.#learners) learner.limit(this.#chosenEnvironments);
    this.#key = newKey(); // another sweep than the one that may have been sent
    this.#view.set({ new: JSON.stringify(this.#request()) });
    this.#submitter.disabled = true;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#ask(), PAUSE_MILLISECONDS);
  }

  /** Let the service count and estimate, and find what is wrong. */
  async #ask() {
    this.#asking.abort();
    this.#asking = new AbortController();
    const request = this.#request();
    clearFaults(this.#form);
    at("submission-fault").hidden = true;
    showNotices([]);
    if (request.algorithms.length === 0 || request.environments.length === 0) {
      at("plan").hidden = true;
      setText(at("estimate"), "Choose at least one algorithm and one environment.");
      return;
    }
    try {
      const answer = await post("/sweeps?dry_run=true", request, {}, this.#asking.signal);
      const plan = /** @type {Api.Plan} */ (answer);
      setText(at("estimate"), estimateText(plan));
      showNotices(plan.notices);
      fillPlan(at("plan-table", HTMLTableElement), plan);
      at("plan").hidden = false;
      this.#submitter.disabled = this.#sent;
    } catch (error) {
      if (isDropped(error)) return;
      this.#refused(refusalOf(error));
    }
  }

  async #submit() {
    if (this.#sent || this.#submitter.disabled) return;
    this.#sent = this.#submitter.disabled = true;
    try {
      const headers = { "Idempotency-Key": this.#key };
      const sweep = /** @type {Api.Sweep} */ (await post("/sweeps", this.#request(), headers));
      location.assign(here(`/sweeps/${sweep.id}`));
    } catch (error) {
      this.#sent = this.#submitter.disabled = false;
      this.#refused(refusalOf(error));
    }
  }

  /** @param {import("../connection/api.js").Refusal} refusal */
  #refused({ message, errors }) {
    at("plan").hidden = true;
    setText(at("estimate"), "");
    const learners = this.#learners.filter((learner) => learner.isChosen);
    const fields = [...this.#form.querySelectorAll("[data-fault]")];
    const homeless = showFaults(errors, [
      ...learners.flatMap((learner, i) => learner.places(i)),
      ...fields.map((node) => place(node)),
    ]);
    const rest = errors.length > 0 ? homeless.join(" ") : message;
    setText(at("submission-fault"), rest);
    at("submission-fault").hidden = rest === "";
  }
}

/**
 * What the service remarks on a sweep that it would take.
 *
 * @param {string[]} notices
 */
function showNotices(notices) {
  at("submission-notices").replaceChildren(...notices.map((text) => element("p", {}, text)));
  at("submission-notices").hidden = notices.length === 0;
}

/**
 * The field of a request whose faults belong to a part of the form.
 *
 * @param {Element} node
 * @returns {[field: string, node: Element]}
 */
function place(node) {
  return [node.getAttribute("data-fault") ?? "", node];
}

/**
 * One per sweep that is meant: sent twice, it makes one.
 *
 * @returns {string}
 */
function newKey() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

/**
 * A draft out of the address, empty where it is none.
 *
 * @param {string} text
 * @returns {Draft}
 */
function parsed(text) {
  try {
    const draft = JSON.parse(text);
    return draft !== null && typeof draft === "object" ? draft : {};
  } catch {
    return {};
  }
}
