/** The service's REST interface, as the pages use it. */
import { here } from "../texts/place.js";

const PREFIX = "/api/v1";
const FINAL_STATUSES = [400, 403, 404, 422];

/** What the service refused, in its own words (problem+json), or that it could not be reached. */
export class Refusal extends Error {
  /**
   * @param {number} status of HTTP, 0 when there was no answer at all
   * @param {string} message
   * @param {Api.Fault[]} errors what is wrong where
   */
  constructor(status, message, errors = []) {
    super(message);
    this.status = status;
    this.errors = errors;
  }

  /** Whether the same request would be refused again: what it asks for is wrong. */
  get isFinal() {
    return FINAL_STATUSES.includes(this.status);
  }
}

/**
 * The refusal that was caught; anything else, and a refusal of another status, is thrown on.
 *
 * @param {unknown} error
 * @param {number[]} statuses that are expected; none: all of them
 * @returns {Refusal}
 */
export function refusalOf(error, ...statuses) {
  if (!(error instanceof Refusal)) throw error;
  if (statuses.length > 0 && !statuses.includes(error.status)) throw error;
  return error;
}

/**
 * Whether a request was dropped by whoever made it.
 *
 * @param {unknown} error
 * @returns {boolean}
 */
export function isDropped(error) {
  return error instanceof Error && error.name === "AbortError";
}

/**
 * The address of a resource, with the parameters that are set.
 *
 * @param {string} path
 * @param {object} [parameters] by name, of texts, numbers, truth values, and lists of them
 * @returns {string}
 */
export function address(path, parameters = {}) {
  const query = new URLSearchParams();
  for (const [name, value] of Object.entries(parameters)) {
    for (const each of [value].flat()) {
      if (each !== null && each !== undefined && each !== "") query.append(name, String(each));
    }
  }
  return here(PREFIX + path) + (query.size > 0 ? `?${query}` : "");
}

/**
 * The JSON of a resource; throws Refusal.
 *
 * @template {string} const P
 * @param {P & Api.Known<P, "get">} path
 * @param {Api.Query<P>} [parameters]
 * @param {AbortSignal} [signal]
 * @returns {Promise<Api.Answer<P, "get">>}
 */
export function get(path, parameters = undefined, signal = undefined) {
  return send(address(path, parameters), { signal });
}

/**
 * Ask for an action such as `/sweeps/{id}/cancel`; throws Refusal.
 *
 * @template {string} const P
 * @param {P & Api.Known<P, "post">} path
 * @param {object} [body]
 * @param {Record<string, string>} [headers]
 * @param {AbortSignal} [signal]
 * @returns {Promise<Api.Answer<P, "post">>}
 */
export function post(path, body = undefined, headers = {}, signal = undefined) {
  const sent = { method: "POST", headers: new Headers(headers), signal };
  if (body === undefined) return send(address(path), sent);
  sent.headers.set("Content-Type", "application/json");
  return send(address(path), { ...sent, body: JSON.stringify(body) });
}

/**
 * A picture that the service draws; throws Refusal.
 *
 * @param {string} path
 * @param {object} [parameters]
 * @returns {Promise<Blob>}
 */
export function getPicture(path, parameters = {}) {
  return send(address(path, parameters), {}, (response) => response.blob());
}

/**
 * Delete a resource for good; throws Refusal.
 *
 * @template {string} const P
 * @param {P & Api.Known<P, "delete">} path
 * @returns {Promise<Api.Answer<P, "delete">>}
 */
export function remove(path) {
  return send(address(path), { method: "DELETE" });
}

/**
 * Change some fields of a resource; throws Refusal.
 *
 * @template {string} const P
 * @param {P & Api.Known<P, "patch">} path
 * @param {object} changes
 * @returns {Promise<Api.Answer<P, "patch">>}
 */
export function patch(path, changes) {
  const headers = { "Content-Type": "application/json" };
  return send(address(path), { method: "PATCH", headers, body: JSON.stringify(changes) });
}

/**
 * @param {string} url
 * @param {RequestInit} options
 * @param {(response: Response) => Promise<any>} [read] its body; JSON, whose form the service's
 *   OpenAPI tells to `get` and `post`
 * @returns {Promise<any>}
 */
async function send(url, options, read = (response) => response.json()) {
  let response;
  try {
    response = await fetch(url, options);
  } catch (error) {
    if (isDropped(error)) throw error;
    throw new Refusal(0, "The service cannot be reached.");
  }
  if (!response.ok) throw await refusal(response);
  try {
    return await read(response);
  } catch (error) {
    if (isDropped(error)) throw error;
    throw new Refusal(0, "The connection broke in the middle of an answer.");
  }
}

/**
 * @param {Response} response
 * @returns {Promise<Refusal>}
 */
async function refusal(response) {
  const { status, statusText } = response;
  if (status === 401) {
    return new Refusal(status, "This browser is not signed in.");
  }
  try {
    /** @type {Partial<Api.Problem>} */
    const { detail, title, errors } = await response.json();
    return new Refusal(status, detail || title || `The service answered ${status}.`, errors ?? []);
  } catch {
    return new Refusal(status, `The service answered ${status} ${statusText}.`);
  }
}
