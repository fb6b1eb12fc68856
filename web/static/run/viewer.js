/** The trained policy acting in its task: an episode of the service's, drawn and played. */
import { get } from "../connection/api.js";
import { setText } from "../parts/element.js";
import { count, number } from "../texts/format.js";
import { Player } from "./player.js";
import { Stage } from "./stage.js";
import { Surface } from "./surface.js";

const at = (name) => document.getElementById(name);

/** Where a task leaves a trail, by state. */
const TRAILS = { RollingDie: ([x, y]) => [x, y] };

export class Viewer {
  #view;
  #shown = ""; // what the episode belongs to: the run's state, and a start
  #episode = null;
  #stage;
  #surface = null;
  #player;

  /**
   * @param view its fields "start", "step" and "speed" say which episode, and where it stands
   * @param onAsked () => void; another episode is wanted: `load` is to be called
   */
  constructor(view, onAsked) {
    this.#view = view;
    this.#player = new Player(Number(view.get("speed")));
    this.#player.addEventListener("step", () => {
      if (!this.#player.isPlaying) view.set({ step: this.#player.step });
      this.#draw();
    });
    at("speed").addEventListener("change", () => view.set({ speed: at("speed").value }));
    at("start").value = String(view.get("start"));
    at("start").addEventListener("change", () => {
      if (!at("start").reportValidity()) return;
      view.set({ start: Number(at("start").value), step: 0 });
      onAsked();
    });
    new ResizeObserver(() => this.#draw()).observe(at("stage"));
    document.addEventListener("themechange", () => this.#draw());
  }

  /** Show an episode of a run, where the service offers one; again when the run has ended. */
  async load(run, signal) {
    const start = this.#view.get("start");
    const wanted = `${run.status} ${start}`;
    if (!("rollout" in run.links) || this.#shown === wanted) return;
    at("viewer").hidden = false;
    setText(at("stage-text"), "An episode is being played …");
    try {
      this.#episode = await get(`/runs/${run.id}/rollout`, { seed: start }, signal);
    } catch (error) {
      if (![404, 409, 422].includes(error.status)) throw error;
      setText(at("stage-text"), error.message);
      return;
    }
    this.#shown = wanted;
    this.#show(this.#episode);
  }

  #show(episode) {
    this.#stage = new Stage(at("stage"), episode);
    if (episode.surface) {
      const figure = at("surface");
      this.#surface = new Surface(figure.querySelector("canvas"), episode.surface);
      figure.hidden = false;
      setText(figure.querySelector("figcaption"), this.#surface.caption);
      figure.querySelector("canvas").setAttribute("aria-label", this.#surface.caption);
    }
    at("player").hidden = false;
    this.#player.load(episode.frames.length - 1, episode.dt, this.#view.get("step"));
    setText(at("stage-text"), this.#sentence());
  }

  #draw() {
    if (this.#episode === null) return;
    const { environment, states, actions, rewards, contacts, dt } = this.#episode;
    const { step } = this.#player;
    const before = Math.max(0, step - 1); // the step that led here
    const trailOf = TRAILS[environment];
    const past = trailOf ? contacts.slice(0, before) : []; // what a trail leads past
    this.#stage.draw(step, {
      trail: trailOf ? states.slice(0, step + 1).map(trailOf) : [],
      ghosts: past.flatMap((impulses, k) => (impulses.length > 0 ? [k + 1] : [])),
      faintArrows: past.flat(),
      arrows: step > 0 ? contacts[before] : [],
    });
    const action = actions[Math.min(step, actions.length - 1)];
    this.#surface?.draw(states[step][0], action[0]);
    const reward = step > 0 ? `, reward ${number(rewards[before])}` : "";
    const text = `step ${step} of ${states.length - 1}, ${(step * dt).toFixed(2)} s${reward}`;
    setText(at("step-text"), text);
    at("stage").setAttribute("aria-label", `${environment} at ${text}`);
  }

  #sentence() {
    const { rewards, terminated, contacts, timestep } = this.#episode;
    const total = rewards.reduce((sum, reward) => sum + reward, 0);
    const end = terminated ? "It ended before the time limit. " : "";
    const longest = Math.max(...contacts.flat().map(([, , px, py]) => Math.hypot(px, py)));
    const arrows = Number.isFinite(longest)
      ? `Red arrows are contact impulses, the longest ${number(longest)} N s. `
      : "";
    return (
      `An episode of the policy as of timestep ${count(timestep)}, without noise; ` +
      `return ${number(total)}. ${end}${arrows}` +
      "Keys: k plays and pauses, comma and full stop go a step back and on."
    );
  }
}
