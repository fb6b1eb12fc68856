/** Playback of an episode: play and pause, a step at a time, scrubbing, speed. */
import { at, setText } from "../parts/element.js";

export class Player {
  #last = 0;
  #secondsPerStep = 1;
  #position = 0; // in steps, fractional while it plays
  #playing = false;
  #speed;
  #onStep;
  #scrub = at("scrub", HTMLInputElement);

  /**
   * @param {string} speed to begin with
   * @param {() => void} onStep another step is to be shown
   */
  constructor(speed, onStep) {
    this.#speed = Number(speed);
    this.#onStep = onStep;
    const choice = at("speed", HTMLSelectElement);
    choice.value = speed;
    choice.addEventListener("change", () => (this.#speed = Number(choice.value)));
    at("play").addEventListener("click", () => this.#toggle());
    this.#scrub.addEventListener("input", () => this.#jump(Number(this.#scrub.value)));
    at("viewer").addEventListener("keydown", (event) => this.#onKey(event));
  }

  /**
   * Show an episode.
   *
   * @param {number} last its last step
   * @param {number} secondsPerStep of the task's own time
   * @param {number} step to begin with
   */
  load(last, secondsPerStep, step) {
    if (this.#playing) this.#toggle();
    this.#last = last;
    this.#secondsPerStep = secondsPerStep;
    this.#scrub.max = String(last);
    this.#jump(step);
  }

  get step() {
    return Math.floor(this.#position);
  }

  get isPlaying() {
    return this.#playing;
  }

  #toggle() {
    this.#playing = !this.#playing;
    setText(at("play"), this.#playing ? "Pause" : "Play");
    if (!this.#playing) {
      this.#show();
      return;
    }
    if (this.step === this.#last) this.#position = 0;
    /** @type {number | null} */
    let before = null; // a frame's time is that of its beginning, which may lie before the click
    const advance = (/** @type {number} */ now) => {
      if (!this.#playing) return;
      this.#position += (this.#speed * (now - (before ?? now))) / 1000 / this.#secondsPerStep;
      before = now;
      if (this.#position >= this.#last) {
        this.#position = this.#last;
        this.#toggle();
        return;
      }
      this.#show();
      requestAnimationFrame(advance);
    };
    requestAnimationFrame(advance);
  }

  /** @param {number} step */
  #jump(step) {
    this.#position = Math.max(0, Math.min(this.#last, step));
    this.#show();
  }

  #show() {
    this.#scrub.value = String(this.step);
    this.#onStep();
  }

  /**
   * Keys beside those of the inputs: k plays and pauses, comma and full stop go a step.
   *
   * @param {KeyboardEvent} event
   */
  #onKey(event) {
    if (event.key === "k") this.#toggle();
    else if (event.key === ",") this.#jump(this.step - 1);
    else if (event.key === ".") this.#jump(this.step + 1);
    else return;
    event.preventDefault();
  }
}
