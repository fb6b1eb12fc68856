/**
 * Find, build and update parts of the page. Strings become text nodes and attributes, never HTML, so
 * a sweep called `<img onerror=...>` is shown as just that.
 */

/**
 * A kind of element, such as HTMLInputElement.
 *
 * @template {Element} T
 * @typedef {{ new (): T, name: string }} Kind
 */

/**
 * The element of an id, which the page's template has.
 *
 * @overload
 * @param {string} id
 * @returns {HTMLElement}
 */
/**
 * @template {Element} T
 * @overload
 * @param {string} id
 * @param {Kind<T>} kind what it has to be
 * @returns {T}
 */
/**
 * @param {string} id
 * @param {Kind<Element>} kind
 * @returns {Element}
 */
export function at(id, kind = HTMLElement) {
  return expected(document.getElementById(id), `#${id}`, kind);
}

/**
 * The first element of a selector within another.
 *
 * @overload
 * @param {ParentNode} parent
 * @param {string} selector
 * @returns {HTMLElement}
 */
/**
 * @template {Element} T
 * @overload
 * @param {ParentNode} parent
 * @param {string} selector
 * @param {Kind<T>} kind what it has to be
 * @returns {T}
 */
/**
 * @param {ParentNode} parent
 * @param {string} selector
 * @param {Kind<Element>} kind
 * @returns {Element}
 */
export function within(parent, selector, kind = HTMLElement) {
  return expected(parent.querySelector(selector), selector, kind);
}

/**
 * The input of a name in a form.
 *
 * @template {Element} T
 * @param {HTMLFormElement} form
 * @param {string} name
 * @param {Kind<T>} kind what it has to be
 * @returns {T}
 */
export function field(form, name, kind) {
  return expected(form.elements.namedItem(name), `[name=${name}]`, kind);
}

/**
 * @template {Element} T
 * @param {unknown} found
 * @param {string} name
 * @param {Kind<T>} kind
 * @returns {T}
 */
function expected(found, name, kind) {
  if (found instanceof kind) return found;
  throw new Error(found === null ? `The page has no ${name}.` : `${name} is no ${kind.name}.`);
}

/** @typedef {string | boolean | ((event: any) => void) | null | undefined} Attribute */

/**
 * A DOM element: functions become listeners ("onclick"), of the rest true and false say whether an
 * attribute is there.
 *
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, Attribute>} [attributes]
 * @param {(Node | string | null | undefined)[]} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined) continue;
    if (typeof value === "function") node.addEventListener(name.slice(2), value);
    else if (typeof value === "boolean") node.toggleAttribute(name, value);
    else node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/**
 * An element of a drawing.
 *
 * @template {keyof SVGElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string | number>} attributes
 * @param {Node[]} children
 * @returns {SVGElementTagNameMap[K]}
 */
export function shape(tag, attributes, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, String(value));
  node.append(...children);
  return node;
}

/**
 * Write text only where it changed, so that selections and screen readers are left in peace.
 *
 * @param {Element} node
 * @param {string} text
 */
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/**
 * Keep the children of `parent` in step with a list of items, reusing the node of each key: focus,
 * scroll and open details survive an update.
 *
 * @template T
 * @template {{ node: Element, update: (item: T) => void }} E
 * @param {Element} parent
 * @param {(item: T) => string | number} keyOf
 * @param {(item: T) => E} create
 * @returns {(items: T[]) => E[]} the entries, in order
 */
export function keyed(parent, keyOf, create) {
  /** @type {Map<string | number, E>} */
  const entries = new Map();
  return (items) => {
    const wanted = new Set(items.map(keyOf));
    for (const [key, entry] of entries) {
      if (wanted.has(key)) continue;
      entry.node.remove();
      entries.delete(key);
    }
    let next = parent.firstElementChild;
    return items.map((item) => {
      const key = keyOf(item);
      const entry = entries.get(key) ?? create(item);
      entries.set(key, entry);
      entry.update(item);
      if (entry.node === next) next = next.nextElementSibling;
      else parent.insertBefore(entry.node, next);
      return entry;
    });
  };
}
