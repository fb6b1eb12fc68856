/** The trained policy acting in its task: an episode of the service's, drawn and played. */
import { get } from "./api.js";
import { setText } from "./element.js";
import { number } from "./format.js";
import { Player } from "./player.js";
import { Stage } from "./stage.js";
import { Surface } from "./surface.js";

const at = (name) => document.getElementById(name);

/** Where a task leaves a trail, by state. */
const TRAILS = { RollingDie: ([x, y]) => [x, y] };

export class Viewer {
  #view;
  #shown = ""; // the run's state that the episode belongs to
  #episode = null;
  #stage;
  #surface = null;
  #player;

  /** @param view its fields "step" and "speed" are where the episode stands */
  constructor(view) {
    this.#view = view;
    new ResizeObserver(() => this.#draw()).observe(at("stage"));
    document.addEventListener("themechange", () => this.#draw());
  }

  /** Show an episode of a run, where the service offers one; again when the run has ended. */
  async load(run, signal) {
    if (!("rollout" in run.links) || this.#shown === run.status) return;
    let episode;
    try {
      episode = await get(`/runs/${run.id}/rollout`, {}, signal);
    } catch (error) {
      if (![404, 409, 422].includes(error.status)) throw error;
      return;
    }
    this.#shown = run.status;
    if (this.#episode === null) this.#begin(episode);
  }

  #begin(episode) {
    this.#episode = episode;
    at("viewer").hidden = false;
    this.#stage = new Stage(at("stage"), episode);
    if (episode.surface) {
      const figure = at("surface");
      this.#surface = new Surface(figure.querySelector("canvas"), episode.surface);
      figure.hidden = false;
      setText(figure.querySelector("figcaption"), this.#surface.caption);
      figure.querySelector("canvas").setAttribute("aria-label", this.#surface.caption);
    }
    const start = { step: this.#view.get("step"), speed: Number(this.#view.get("speed")) };
    this.#player = new Player(episode.frames.length - 1, episode.dt, start);
    this.#player.addEventListener("step", () => {
      if (!this.#player.isPlaying) this.#view.set({ step: this.#player.step });
      this.#draw();
    });
    at("speed").addEventListener("change", () => this.#view.set({ speed: at("speed").value }));
    setText(at("stage-text"), this.#sentence());
    this.#draw();
  }

  #draw() {
    if (this.#episode === null) return;
    const { environment, states, actions, rewards, contacts, dt } = this.#episode;
    const { step } = this.#player;
    const before = Math.max(0, step - 1); // the step that led here
    const trailOf = TRAILS[environment];
    const touched = (k) => (contacts?.[k] ?? []).length > 0;
    this.#stage.draw(step, {
      trail: trailOf ? states.slice(0, step + 1).map(trailOf) : [],
      ghosts: trailOf ? actions.flatMap((_, k) => (k < step && touched(k) ? [k + 1] : [])) : [],
      arrows: step > 0 ? (contacts?.[before] ?? []) : [],
    });
    const action = actions[Math.min(step, actions.length - 1)];
    this.#surface?.draw(states[step][0], action[0]);
    const reward = step > 0 ? `, reward ${number(rewards[before])}` : "";
    const text = `step ${step} of ${states.length - 1}, ${(step * dt).toFixed(2)} s${reward}`;
    setText(at("step-text"), text);
    at("stage").setAttribute("aria-label", `${environment} at ${text}`);
  }

  #sentence() {
    const { rewards, terminated, contacts } = this.#episode;
    const total = rewards.reduce((sum, reward) => sum + reward, 0);
    const end = terminated ? "It ended before the time limit. " : "";
    const arrows = contacts?.some((each) => each.length > 0)
      ? "Red arrows are contact impulses. "
      : "";
    return (
      `An episode of the policy as it was saved last, without noise; return ${number(total)}. ` +
      `${end}${arrows}Keys: k plays and pauses, comma and full stop go a step back and on.`
    );
  }
}
