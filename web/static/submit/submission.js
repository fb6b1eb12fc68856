/** The form that submits a sweep, made of the catalogue; its draft lives in the address. */
import { get, post } from "../connection/api.js";
import { element, setText } from "../parts/element.js";
import { clearFaults, showFaults } from "./faults.js";
import { LearnerFields, readSetting } from "./learner_fields.js";
import { estimateText, fillPlan } from "./plan.js";

const PAUSE_MILLISECONDS = 250; // after the last key, before the service is asked
const at = (name) => document.getElementById(name);

export class Submission {
  #view;
  #form = at("submission-form");
  #learners = [];
  #environments = [];
  #key = newKey();
  #sent = false;
  #asking = new AbortController();
  #timer = 0;

  /** @param view its field "new" is the draft as JSON, "" while the form is closed */
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

  async #open(draft) {
    this.#view.set({ new: draft });
    at("submission").hidden = false;
    at("new").setAttribute("aria-expanded", "true");
    if (this.#learners.length === 0) await this.#build();
    this.#fill(parsed(draft));
    this.#form.elements.name.focus();
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
    this.#learners = algorithms.map((algorithm) => new LearnerFields(algorithm));
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

  #fill(draft) {
    const { name, seeds, timesteps, scale, priority } = this.#form.elements;
    name.value = draft.name ?? "";
    seeds.value = [draft.seeds ?? 4].flat().join(", ");
    timesteps.value = draft.timesteps ?? "";
    scale.value = draft.scale ?? "";
    priority.value = draft.priority ?? "";
    for (const learner of this.#learners) {
      learner.fill(draft.algorithms?.find((each) => each.name === learner.algorithm.name));
    }
    for (const box of this.#environments) {
      box.checked = draft.environments?.includes(box.value) ?? false;
    }
  }

  /** What `POST /sweeps` takes. */
  #request() {
    const { name, seeds, timesteps, scale, priority } = this.#form.elements;
    const environments = this.#chosenEnvironments;
    const listed = seeds.value.split(",").map((each) => readSetting(each.trim()));
    const chosen = this.#learners.filter((learner) => learner.isChosen);
    return {
      ...(name.value.trim() ? { name: name.value.trim() } : {}),
      algorithms: chosen.map((learner) => learner.request(environments)),
      environments,
      seeds: listed.length === 1 ? listed[0] : listed,
      ...(timesteps.value.trim() ? { timesteps: readSetting(timesteps.value.trim()) } : {}),
      ...(scale.value.trim() ? { scale: readSetting(scale.value.trim()) } : {}),
      ...(priority.value.trim() ? { priority: readSetting(priority.value.trim()) } : {}),
    };
  }

  get #chosenEnvironments() {
    return this.#environments.filter((box) => box.checked).map((box) => box.value);
  }

  #onInput() {
    for (const learner of this.#learners) learner.limit(this.#chosenEnvironments);
    this.#key = newKey(); // another sweep than the one that may have been sent
    this.#view.set({ new: JSON.stringify(this.#request()) });
    at("submit").disabled = true;
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
      const plan = await post("/sweeps?dry_run=true", request, {}, this.#asking.signal);
      setText(at("estimate"), estimateText(plan));
      showNotices(plan.notices);
      fillPlan(at("plan-table"), plan);
      at("plan").hidden = false;
      at("submit").disabled = this.#sent;
    } catch (error) {
      if (error.name === "AbortError") return;
      this.#refused(error);
    }
  }

  async #submit() {
    if (this.#sent || at("submit").disabled) return;
    this.#sent = at("submit").disabled = true;
    try {
      const sweep = await post("/sweeps", this.#request(), { "Idempotency-Key": this.#key });
      location.assign(`/sweeps/${sweep.id}`);
    } catch (error) {
      this.#sent = at("submit").disabled = false;
      this.#refused(error);
    }
  }

  #refused({ message, errors }) {
    at("plan").hidden = true;
    setText(at("estimate"), "");
    const learners = this.#learners.filter((learner) => learner.isChosen);
    const fields = [...this.#form.querySelectorAll("[data-fault]")];
    const homeless = showFaults(errors ?? [], [
      ...learners.flatMap((learner, i) => learner.places(i)),
      ...fields.map((node) => [node.dataset.fault, node]),
    ]);
    const rest = errors?.length > 0 ? homeless.join(" ") : message;
    setText(at("submission-fault"), rest);
    at("submission-fault").hidden = rest === "";
  }
}

/** What the service remarks on a sweep that it would take. */
function showNotices(notices) {
  at("submission-notices").replaceChildren(...notices.map((text) => element("p", {}, text)));
  at("submission-notices").hidden = notices.length === 0;
}

/** One per sweep that is meant: sent twice, it makes one. */
function newKey() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** A draft out of the address, empty where it is none. */
function parsed(text) {
  try {
    const draft = JSON.parse(text);
    return draft !== null && typeof draft === "object" ? draft : {};
  } catch {
    return {};
  }
}
