/**
 * Build and update parts of the page. Strings become text nodes and attributes, never HTML, so a
 * sweep called `<img onerror=...>` is shown as just that.
 */

/** A DOM element: functions become listeners ("onclick"), booleans properties, the rest attributes. */
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined) continue;
    if (typeof value === "function") node.addEventListener(name.slice(2), value);
    else if (typeof value === "boolean") node[name] = value;
    else node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/** Write text only where it changed, so that selections and screen readers are left in peace. */
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/**
 * Keep the children of `parent` in step with a list of items, reusing the node of each key: focus,
 * scroll and open details survive an update.
 *
 * @param create (item) => { node, update(item) }
 * @returns (items) => the entries, in order
 */
export function keyed(parent, keyOf, create) {
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
      if (!entries.has(key)) entries.set(key, create(item));
      const entry = entries.get(key);
      entry.update(item);
      if (entry.node === next) next = next.nextElementSibling;
      else parent.insertBefore(entry.node, next);
      return entry;
    });
  };
}
