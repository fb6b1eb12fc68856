/** Whoever looks at the page, as the service knows them. */

const { user, scope } = document.body.dataset;

/** Whether they came by a shared link, and see what that shares alone. */
export const isGuest = "guest" in document.body.dataset;

/**
 * Whether they may change the sweeps of an owner.
 *
 * @param {string} owner
 * @returns {boolean}
 */
export function mayChange(owner) {
  return scope === "admin" || user === owner;
}

/**
 * "by ann", of the sweep of somebody else.
 *
 * @param {string} owner
 * @returns {string}
 */
export function ownerText(owner) {
  return owner === user ? "" : `by ${owner}`;
}
