/** The service's REST interface, as the pages use it. */

const PREFIX = "/api/v1";

/** What the service refused, in its own words (problem+json), or that it could not be reached. */
export class Refusal extends Error {
  /**
   * @param status HTTP status, 0 when there was no answer at all
   * @param errors [{ field, message }]: what is wrong where
   */
  constructor(status, message, errors = []) {
    super(message);
    this.status = status;
    this.errors = errors;
  }
}

/** The address of a resource, with the parameters that are set. */
export function address(path, parameters = {}) {
  const query = new URLSearchParams();
  for (const [name, value] of Object.entries(parameters)) {
    if (value !== null && value !== undefined && value !== "") query.set(name, value);
  }
  return PREFIX + path + (query.size > 0 ? `?${query}` : "");
}

/** The JSON of a resource; throws Refusal. */
export function get(path, parameters = {}, signal = undefined) {
  return send(address(path, parameters), { signal });
}

/** Ask for an action such as `/sweeps/{id}/cancel`; throws Refusal. */
export function post(path, body = undefined, headers = {}, signal = undefined) {
  const json = body === undefined ? {} : { "Content-Type": "application/json" };
  const sent = { method: "POST", headers: { ...json, ...headers }, signal };
  return send(address(path), { ...sent, body: JSON.stringify(body) });
}

async function send(url, options) {
  let response;
  try {
    response = await fetch(url, options);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Refusal(0, "The service cannot be reached.");
  }
  if (!response.ok) throw await refusal(response);
  try {
    return await response.json();
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Refusal(0, "The connection broke off in the middle of an answer.");
  }
}

async function refusal(response) {
  const { status, statusText } = response;
  if (status === 401) {
    const advice = "This browser is not signed in. Open the link that `d3pg serve` printed.";
    return new Refusal(status, advice);
  }
  try {
    const { detail, title, errors } = await response.json();
    return new Refusal(status, detail || title || `The service answered ${status}.`, errors ?? []);
  } catch {
    return new Refusal(status, `The service answered ${status} ${statusText}.`);
  }
}
