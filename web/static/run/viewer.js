/** The trained policy acting in its task: an episode of the service's, drawn and played. */
import { get, refusalOf } from "../connection/api.js";
import { at, setText, within } from "../parts/element.js";
import { count, number } from "../texts/format.js";
import { taskName } from "../texts/task.js";
import { Player } from "./player.js";
import { Stage } from "./stage.js";
import { Surface } from "./surface.js";

/**
 * @import { Field, View } from "../parts/view.js"
 *
 * @typedef {object} Fields
 * @property {Field<number>} start
 * @property {Field<number>} step
 * @property {Field<"1" | "0.25" | "0.5" | "2" | "4">} speed
 */

/**
 * Where a task leaves a trail, by state.
 *
 * @type {Map<string, (state: number[]) => number[]>}
 */
const TRAILS = new Map([["RollingDie", ([x, y]) => [x, y]]]);

export class Viewer {
  #view;
  #shown = ""; // what the episode belongs to: the run's state, and a start
  /** @type {Api.Episode | null} */
  #episode = null;
  /** @type {Stage | null} */
  #stage = null;
  /** @type {Surface | null} */
  #surface = null;
  #player;

  /**
   * @param {View<Fields>} view which episode, and where it stands
   * @param {() => void} onAsked another episode is wanted: `load` is to be called
   */
  constructor(view, onAsked) {
    this.#view = view;
    this.#player = new Player(view.get("speed"), () => {
      if (!this.#player.isPlaying) view.set({ step: this.#player.step });
      this.#draw();
    });
    const speed = at("speed", HTMLSelectElement);
    speed.addEventListener("change", () => {
      view.set({ speed: /** @type {Fields["speed"]["initial"]} */ (speed.value) });
    });
    const start = at("start", HTMLInputElement);
    start.value = String(view.get("start"));
    start.addEventListener("change", () => {
      if (!start.reportValidity()) return;
      view.set({ start: Number(start.value), step: 0 });
      onAsked();
    });
    new ResizeObserver(() => this.#draw()).observe(at("stage"));
    document.addEventListener("themechange", () => this.#draw());
  }

  /**
   * Show an episode of a run, where the service offers one; again when the run has ended.
   *
   * @param {Api.Run} run
   * @param {AbortSignal} signal
   */
  async load(run, signal) {
    const start = this.#view.get("start");
    const wanted = `${run.status} ${start}`;
    if (!("rollout" in run.links) || this.#shown === wanted) return;
    at("viewer").hidden = false;
    setText(at("stage-text"), "An episode is being played …");
    try {
      this.#episode = await get(`/runs/${run.id}/rollout`, { seed: start }, signal);
    } catch (error) {
      setText(at("stage-text"), refusalOf(error, 404, 409, 422).message);
      return;
    }
    this.#shown = wanted;
    this.#show(this.#episode);
  }

  /** @param {Api.Episode} episode */
  #show(episode) {
    this.#stage = new Stage(at("stage", HTMLCanvasElement), episode);
    if (episode.surface) {
      const figure = at("surface");
      const canvas = within(figure, "canvas", HTMLCanvasElement);
      this.#surface = new Surface(canvas, episode.surface);
      figure.hidden = false;
      setText(within(figure, "figcaption"), this.#surface.caption);
      canvas.setAttribute("aria-label", this.#surface.caption);
    }
    at("player").hidden = false;
    this.#player.load(episode.frames.length - 1, episode.dt, this.#view.get("step"));
    setText(at("stage-text"), sentence(episode));
  }

  #draw() {
    if (this.#episode === null) return;
    const { environment, states, actions, rewards, contacts, dt } = this.#episode;
    const { step } = this.#player;
    const before = Math.max(0, step - 1); // the step that led here
    const trailOf = TRAILS.get(taskName(environment));
    const past = trailOf ? contacts.slice(0, before) : []; // what a trail leads past
    this.#stage?.draw(step, {
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
}

/**
 * What an episode is, in words.
 *
 * @param {Api.Episode} episode
 * @returns {string}
 */
function sentence({ rewards, terminated, contacts, timestep }) {
  const total = rewards.reduce((sum, reward) => sum + reward, 0);
  const end = terminated ? "It ended before the time limit. " : "";
  const longest = Math.max(...contacts.flat().map(([, , px, py]) => Math.hypot(px, py)));
  const arrows = Number.isFinite(longest)
    ? `Red arrows are contact impulses, the longest ${number(longest)} N s. `
    : "";
  return (
    `An episode of the policy as of timestep ${count(timestep)}, without noise; ` +
    `return ${number(total)}. ${end}${arrows}` +
    "Keys: k plays and pauses, comma and full stop go one step back and forward."
  );
}
