/** What a person chose to see. All of it lives in the address, so that a link shows the same. */

/** A field reads its value out of the address's texts, null when they make no sense. */
const oneOf = (...choices) => ({
  initial: choices[0],
  parse: ([text]) => (choices.includes(text) ? text : null),
  format: (choice) => [choice],
});
const flag = {
  initial: false,
  parse: ([text]) => (text === "1" ? true : null),
  format: (value) => (value ? ["1"] : []),
};
const name = (initial) => ({
  initial,
  parse: ([text]) => (/^[\w.-]+$/.test(text) ? text : null),
  format: (value) => [value],
});
const share = {
  initial: 0,
  parse: ([text]) => (Number(text) > 0 && Number(text) < 1 ? Number(text) : null),
  format: (value) => [String(value)],
};
const list = {
  initial: [],
  parse: (texts) => texts,
  format: (items) => items,
};

const FIELDS = {
  metric: name("return_mean"),
  scale: oneOf("normalized", "raw"),
  x: oneOf("timesteps", "updates", "jacobians", "seconds"),
  band: oneOf("std", "ci95", "iqr", "none"),
  logx: flag,
  logy: flag,
  smoothing: share,
  seeds: flag,
  hide: list, // labels of curves
  table: list, // environments whose table is open
  runs: oneOf("all", "running", "queued", "succeeded", "failed", "diverged", "cancelled"),
};

/** Dispatches "change" with detail: the names of the fields that changed. */
export class View extends EventTarget {
  #values = {};

  constructor() {
    super();
    this.#read();
    window.addEventListener("popstate", () => {
      this.#read();
      this.#announce(Object.keys(FIELDS));
    });
  }

  get(field) {
    return this.#values[field];
  }

  /** Change some fields; the address follows, without a new entry in the browser's history. */
  set(changes) {
    Object.assign(this.#values, changes);
    const query = this.#query();
    history.replaceState(null, "", query.size > 0 ? `?${query}` : location.pathname);
    this.#announce(Object.keys(changes));
  }

  /** Everything as a first visit shows it. */
  reset() {
    this.set(initial());
  }

  get isInitial() {
    return this.#query().size === 0;
  }

  #announce(fields) {
    this.dispatchEvent(new CustomEvent("change", { detail: fields }));
  }

  #read() {
    const query = new URLSearchParams(location.search);
    this.#values = initial();
    for (const [name, field] of Object.entries(FIELDS)) {
      const value = query.has(name) ? field.parse(query.getAll(name)) : null;
      if (value !== null) this.#values[name] = value;
    }
  }

  /** Only what differs from a first visit's view. */
  #query() {
    const query = new URLSearchParams();
    for (const [name, field] of Object.entries(FIELDS)) {
      const texts = field.format(this.#values[name]);
      if (String(texts) === String(field.format(field.initial))) continue;
      for (const text of texts) query.append(name, text);
    }
    return query;
  }
}

function initial() {
  return Object.fromEntries(Object.entries(FIELDS).map(([name, field]) => [name, field.initial]));
}
