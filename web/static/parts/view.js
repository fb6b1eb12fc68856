/** What a person chose to see. All of it lives in the address, so that a link shows the same. */

/**
 * A field of a view: it reads its value out of the address's texts, null when they make no sense.
 *
 * @template T
 * @typedef {{ initial: T, parse(texts: string[]): T | null, format(value: T): string[] }} Field
 */

/**
 * The values of a view's fields.
 *
 * @template {Record<string, Field<any>>} F
 * @typedef {{ [K in keyof F]: F[K]["initial"] }} Values
 */

/**
 * @template {string} const T
 * @param {[T, ...T[]]} choices
 * @returns {Field<T>}
 */
export const oneOf = (...choices) => ({
  initial: choices[0],
  parse: ([text]) => choices.find((choice) => choice === text) ?? null,
  format: (choice) => [choice],
});
/** @type {Field<boolean>} */
export const flag = {
  initial: false,
  parse: ([text]) => (text === "1" ? true : null),
  format: (value) => (value ? ["1"] : []),
};
/** @type {Field<boolean>} */
export const on = {
  initial: true,
  parse: ([text]) => (text === "0" ? false : null),
  format: (value) => (value ? [] : ["0"]),
};
/** @type {(initial: string) => Field<string>} */
export const name = (initial) => ({
  initial,
  parse: ([text]) => (/^[\w.-]+$/.test(text) ? text : null),
  format: (value) => [value],
});
/** @type {Field<string>} */
export const text = {
  initial: "",
  parse: ([value]) => value,
  format: (value) => [value],
};
/** @type {Field<number>} */
export const share = {
  initial: 0,
  parse: ([text]) => (Number(text) > 0 && Number(text) < 1 ? Number(text) : null),
  format: (value) => [String(value)],
};
/** @type {Field<number>} */
export const whole = {
  initial: 0,
  parse: ([text]) => (/^\d{1,9}$/.test(text) ? Number(text) : null),
  format: (value) => [String(value)],
};
/** @type {Field<number | null>} */
export const limit = {
  initial: null,
  parse: ([text]) => (text !== "" && Number.isFinite(Number(text)) ? Number(text) : null),
  format: (value) => (value === null ? [] : [String(value)]),
};
/** @type {Field<string[]>} */
export const list = {
  initial: [],
  parse: (texts) => texts,
  format: (items) => items,
};

/** What stands at the x axis, where it is not the field's own value. */
const X_LABELS = new Map([["seconds", "processor seconds of training"]]);

/**
 * @param {string} x
 * @returns {string}
 */
export function xLabel(x) {
  return X_LABELS.get(x) ?? x;
}

/** How learning curves are looked at, wherever they are drawn. */
export const CURVE_FIELDS = {
  x: oneOf("timesteps", "updates", "jacobians", "seconds"),
  logx: flag,
  logy: flag,
  smoothing: share,
  from: limit, // of the x axis, as zoomed
  to: limit,
  ymin: limit,
  ymax: limit,
  robust: flag, // whether the y axis leaves outliers out
  table: list, // charts whose table is open
};

/** Which curves of many are shown. */
export const SELECTION_FIELDS = {
  hide: list, // labels
  match: text, // words of labels
  top: whole, // how many of the highest; 0 for all
  order: oneOf("submitted", "value"), // of the legend
};

/** How the curves of many learners in many tasks are looked at. */
export const COMPARISON_FIELDS = {
  ...CURVE_FIELDS,
  ...SELECTION_FIELDS,
  metric: name("return_mean"),
  scale: oneOf("normalized", "raw"),
  band: oneOf("std", "ci95", "iqr", "none"),
  seeds: flag, // each as a line
  align: flag, // whether all panels have one y axis
};

/** @template {Record<string, Field<any>>} F */
export class View {
  #fields;
  /** @type {Values<F>} */
  #values;
  /** @type {((fields: string[]) => void)[]} */
  #listeners = [];

  /** @param {F} fields by name, made of the kinds above */
  constructor(fields) {
    this.#fields = fields;
    this.#values = this.#read();
    window.addEventListener("popstate", () => {
      this.#values = this.#read();
      this.#announce(Object.keys(fields));
    });
  }

  /**
   * @template {keyof F} K
   * @param {K} field
   * @returns {F[K]["initial"]}
   */
  get(field) {
    return this.#values[field];
  }

  /**
   * Have a function called whenever fields change.
   *
   * @param {(fields: string[]) => void} listener takes the names of those that changed
   */
  onChange(listener) {
    this.#listeners.push(listener);
  }

  /**
   * Change some fields; the address follows, without a new entry in the browser's history.
   *
   * @param {Partial<Values<F>>} changes
   */
  set(changes) {
    Object.assign(this.#values, changes);
    const query = this.#query();
    history.replaceState(null, "", query.size > 0 ? `?${query}` : location.pathname);
    this.#announce(Object.keys(changes));
  }

  /** Show everything as a first visit does. */
  reset() {
    this.set(this.#initial());
  }

  get isInitial() {
    return this.#query().size === 0;
  }

  /** @param {string[]} fields */
  #announce(fields) {
    for (const listener of this.#listeners) listener(fields);
  }

  /** @returns {Values<F>} */
  #read() {
    const query = new URLSearchParams(location.search);
    const entries = Object.entries(this.#fields).map(([name, field]) => {
      const value = query.has(name) ? field.parse(query.getAll(name)) : null;
      return [name, value ?? field.initial];
    });
    return Object.fromEntries(entries);
  }

  /** Only what differs from a first visit's view. */
  #query() {
    const query = new URLSearchParams();
    for (const [name, { format, initial }] of Object.entries(this.#fields)) {
      const texts = format(this.#values[name]);
      if (String(texts) === String(format(initial))) continue;
      for (const each of texts) query.append(name, each);
    }
    return query;
  }

  /** @returns {Values<F>} */
  #initial() {
    const entries = Object.entries(this.#fields).map(([name, { initial }]) => [name, initial]);
    return Object.fromEntries(entries);
  }
}
