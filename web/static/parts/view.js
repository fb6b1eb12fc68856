/** What a person chose to see. All of it lives in the address, so that a link shows the same. */

// A field reads its value out of the address's texts, null when they make no sense.

export const oneOf = (...choices) => ({
  initial: choices[0],
  parse: ([text]) => (choices.includes(text) ? text : null),
  format: (choice) => [choice],
});
export const flag = {
  initial: false,
  parse: ([text]) => (text === "1" ? true : null),
  format: (value) => (value ? ["1"] : []),
};
export const name = (initial) => ({
  initial,
  parse: ([text]) => (/^[\w.-]+$/.test(text) ? text : null),
  format: (value) => [value],
});
export const text = {
  initial: "",
  parse: ([value]) => value,
  format: (value) => [value],
};
export const share = {
  initial: 0,
  parse: ([text]) => (Number(text) > 0 && Number(text) < 1 ? Number(text) : null),
  format: (value) => [String(value)],
};
export const whole = {
  initial: 0,
  parse: ([text]) => (/^\d{1,9}$/.test(text) ? Number(text) : null),
  format: (value) => [String(value)],
};
export const list = {
  initial: [],
  parse: (texts) => texts,
  format: (items) => items,
};

/** What stands at the x axis, where it is not the field's own value. */
const X_LABELS = { seconds: "processor seconds of training" };

export function xLabel(x) {
  return X_LABELS[x] ?? x;
}

/** How learning curves are looked at, wherever they are drawn. */
export const CURVE_FIELDS = {
  x: oneOf("timesteps", "updates", "jacobians", "seconds"),
  logx: flag,
  logy: flag,
  smoothing: share,
  table: list, // charts whose table is open
};

/** Dispatches "change" with detail: the names of the fields that changed. */
export class View extends EventTarget {
  #fields;
  #values = {};

  /** @param fields by name, made of the kinds above */
  constructor(fields) {
    super();
    this.#fields = fields;
    this.#read();
    window.addEventListener("popstate", () => {
      this.#read();
      this.#announce(Object.keys(fields));
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

  /** Everything as a first visit shows it, but for some fields. */
  reset(kept = []) {
    const values = Object.fromEntries(kept.map((field) => [field, this.#values[field]]));
    this.set({ ...this.#initial(), ...values });
  }

  get isInitial() {
    return this.#query().size === 0;
  }

  #announce(fields) {
    this.dispatchEvent(new CustomEvent("change", { detail: fields }));
  }

  #read() {
    const query = new URLSearchParams(location.search);
    this.#values = this.#initial();
    for (const [name, field] of Object.entries(this.#fields)) {
      const value = query.has(name) ? field.parse(query.getAll(name)) : null;
      if (value !== null) this.#values[name] = value;
    }
  }

  /** Only what differs from a first visit's view. */
  #query() {
    const query = new URLSearchParams();
    for (const [name, field] of Object.entries(this.#fields)) {
      const texts = field.format(this.#values[name]);
      if (String(texts) === String(field.format(field.initial))) continue;
      for (const text of texts) query.append(name, text);
    }
    return query;
  }

  #initial() {
    const entries = Object.entries(this.#fields);
    return Object.fromEntries(entries.map(([name, field]) => [name, field.initial]));
  }
}
