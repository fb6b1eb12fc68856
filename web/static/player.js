/** Playback of an episode: play and pause, a step at a time, scrubbing, speed. */
import { setText } from "./element.js";

const at = (name) => document.getElementById(name);

/** Dispatches "step" whenever another step is to be shown. */
export class Player extends EventTarget {
  #last;
  #secondsPerStep;
  #position = 0; // in steps, fractional while it plays
  #playing = false;
  #speed;

  /**
   * @param last the last step
   * @param secondsPerStep of the task's own time
   * @param start { step, speed } to begin with
   */
  constructor(last, secondsPerStep, { step, speed }) {
    super();
    this.#last = last;
    this.#secondsPerStep = secondsPerStep;
    this.#position = Math.min(step, last);
    this.#speed = speed;
    at("scrub").max = String(last);
    at("scrub").value = String(this.step);
    at("speed").value = String(speed);
    at("play").addEventListener("click", () => this.#toggle());
    at("scrub").addEventListener("input", () => this.#jump(Number(at("scrub").value)));
    at("speed").addEventListener("change", () => (this.#speed = Number(at("speed").value)));
    at("viewer").addEventListener("keydown", (event) => this.#onKey(event));
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
