/** The service's REST interface, as the pages use it. */

const PREFIX = "/api/v1";

/** What the service refused, in its own words (problem+json), or that it could not be reached. */
export class Refusal extends Error {
  /** @param status HTTP status, 0 when there was no answer at all */
  constructor(status, message) {
    super(message);
    this.status = status;
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
export function post(path, body = undefined) {
  const json = body === undefined ? {} : { "Content-Type": "application/json" };
  return send(address(path), { method: "POST", headers: json, body: JSON.stringify(body) });
}

async function send(url, options) {
  let response;
  try {
    response = await fetch(url, options);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Refusal(0, "The service cannot be reached.");
  }
  if (!response.ok) throw new Refusal(response.status, await explanation(response));
  try {
    return await response.json();
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Refusal(0, "The connection broke off in the middle of an answer.");
  }
}

async function explanation(response) {
  if (response.status === 401) {
    return "This browser is not signed in. Open the link that `d3pg serve` printed.";
  }
  try {
    const problem = await response.json();
    return problem.detail || problem.title || `The service answered ${response.status}.`;
  } catch {
    return `The service answered ${response.status} ${response.statusText}.`;
  }
}
