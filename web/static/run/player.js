/** Playback of an episode: play and pause, a step at a time, scrubbing, speed. */
import { setText } from "../parts/element.js";

const at = (name) => document.getElementById(name);

/** Dispatches "step" whenever another step is to be shown. */
export class Player extends EventTarget {
  #last = 0;
  #secondsPerStep = 1;
  #position = 0; // in steps, fractional while it plays
  #playing = false;
  #speed;

  /** @param speed to begin with */
  constructor(speed) {
    super();
    this.#speed = speed;
    at("speed").value = String(speed);
    at("play").addEventListener("click", () => this.#toggle());
    at("scrub").addEventListener("input", () => this.#jump(Number(at("scrub").value)));
    at("speed").addEventListener("change", () => (this.#speed = Number(at("speed").value)));
    at("viewer").addEventListener("keydown", (event) => this.#onKey(event));
  }

  /**
   * Show an episode.
   *
   * @param last its last step
   * @param secondsPerStep of the task's own time
   * @param step to begin with
   */
  load(last, secondsPerStep, step) {
    if (this.#playing) this.#toggle();
    this.#last = last;
    this.#secondsPerStep = secondsPerStep;
    at("scrub").max = String(last);
    this.#jump(step);
  }

  get step() {
    return Math.floor(this.#position);
  }

  get speed() {
    return this.#speed;
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
    let before = null; // a frame's time is that of its beginning, which may lie before the click
    const advance = (now) => {
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

  #jump(step) {
    this.#position = Math.max(0, Math.min(this.#last, step));
    this.#show();
  }

  #show() {
    at("scrub").value = String(this.step);
    this.dispatchEvent(new Event("step"));
  }

  /** Keys beside those of the inputs: k plays and pauses, comma and full stop go a step. */
  #onKey(event) {
    const jumps = { ",": this.step - 1, ".": this.step + 1 };
    if (event.key === "k") this.#toggle();
    else if (event.key in jumps) this.#jump(jumps[event.key]);
    else return;
    event.preventDefault();
  }
}
