/** Where gradients help a run or a sweep: asked for with a button, then shown as figures. */
import { address, get, getPicture, post, refusalOf } from "../connection/api.js";
import * as connection from "../connection/state.js";
import { at, element, setText } from "../parts/element.js";
import { askingOf, stateText } from "../texts/diagnosis.js";

const FORMS = /** @type {const} */ (["svg", "png", "pdf"]);

/** @typedef {`/runs/${string}` | `/sweeps/${string}`} Subject */

export class DiagnosisSection {
  #subject;
  #refetch;
  /** @type {Api.Diagnosis | null} */
  #answer = null;
  #isInView = false;
  #drawn = ""; // what the figures show: task, and how many runs

  /**
   * @param {Subject} subject whose diagnosis it is
   * @param {() => void} refetch asks for `load` to be called at once
   */
  constructor(subject, refetch) {
    this.#subject = subject;
    this.#refetch = refetch;
    at("diagnose").addEventListener("click", () => this.#ask());
    at("diagnosis-task").addEventListener("change", () => this.#draw());
    new IntersectionObserver(([{ isIntersecting }]) => {
      this.#isInView = isIntersecting;
      this.#draw();
    }).observe(at("diagnosis"));
  }

  /** @param {AbortSignal} signal */
  async load(signal) {
    try {
      this.#show(await get(`${this.#subject}/diagnosis`, {}, signal));
    } catch (error) {
      refusalOf(error, 404); // which is told where the subject is loaded
    }
  }

  async #ask() {
    const button = at("diagnose", HTMLButtonElement);
    button.disabled = true;
    try {
      this.#show(await post(`${this.#subject}/diagnosis`));
    } catch (error) {
      connection.refused(refusalOf(error));
    }
    button.disabled = false;
    this.#refetch();
  }

  /** @param {Api.Diagnosis} answer */
  #show(answer) {
    this.#answer = answer;
    const asking = askingOf(answer);
    at("diagnose").hidden = asking === "";
    setText(at("diagnose"), asking);
    const progress = at("diagnosis-progress", HTMLProgressElement);
    progress.hidden = answer.waiting === 0;
    progress.value = answer.runs > 0 ? (answer.done + answer.failed) / answer.runs : 0;
    setText(at("diagnosis-state"), stateText(answer));
    const remarks = [...answer.remarks, ...answer.problems];
    at("diagnosis-remarks").hidden = remarks.length === 0;
    at("diagnosis-remarks").replaceChildren(...remarks.map((text) => element("li", {}, text)));
    this.#offerTasks(answer);
    this.#draw();
  }

  /**
   * The tasks that there are figures of; the one that was chosen stays chosen.
   *
   * @param {Api.Diagnosis} answer
   */
  #offerTasks({ cells }) {
    const tasks = [...new Set(cells.map((cell) => cell.environment))];
    const select = at("diagnosis-task", HTMLSelectElement);
    at("diagnosis-tasks").hidden = tasks.length < 2;
    const offered = Array.from(select.options, (option) => option.value);
    if (tasks.join() === offered.join()) return;
    const chosen = select.value;
    select.replaceChildren(...tasks.map((task) => element("option", { value: task }, task)));
    if (tasks.includes(chosen)) select.value = chosen;
  }

  /** Draw what is made, once none waits any more and somebody looks. */
  #draw() {
    if (this.#answer === null || this.#answer.waiting > 0 || !this.#isInView) return;
    const task = at("diagnosis-task", HTMLSelectElement).value;
    const wanted = `${task} ${this.#answer.done}`;
    if (this.#drawn === wanted) return;
    this.#drawn = wanted;
    const figures = this.#answer.figures.map((figure) => this.#figure(figure, task));
    at("diagnosis-figures").replaceChildren(...figures);
  }

  /**
   * @param {Api.DiagnosisFigure} figure
   * @param {string} task
   * @returns {HTMLElement}
   */
  #figure({ name, title, definition, reading }, task) {
    const parameters = this.#subject.startsWith("/sweeps") ? { environment: task } : {};
    const path = (/** @type {string} */ form) => `${this.#subject}/diagnosis/${name}.${form}`;
    const downloads = FORMS.map((form) => {
      const text = form.toUpperCase();
      const href = address(path(form), parameters);
      return element("a", { href, download: true, "aria-label": `${title} as ${text}` }, text);
    });
    const picture = element("img", { alt: `${title}. ${definition}` });
    load(picture, path("svg"), parameters);
    return element(
      "figure",
      {},
      element("h3", {}, title),
      picture,
      element("figcaption", { class: "definition" }, reading),
      element("p", { class: "downloads" }, ...downloads),
    );
  }
}

/**
 * Fetch a picture; not by its address, under which the browser would show an older one again.
 *
 * @param {HTMLImageElement} picture
 * @param {string} path
 * @param {object} parameters
 */
async function load(picture, path, parameters) {
  try {
    const address = URL.createObjectURL(await getPicture(path, parameters));
    picture.addEventListener("load", () => URL.revokeObjectURL(address));
    picture.src = address;
  } catch (error) {
    picture.replaceWith(element("p", { class: "muted" }, refusalOf(error).message));
  }
}
