/**
 * A list of the service that is read page by page and kept as far as it was read.
 *
 * @template T
 */
export class Listing {
  #read;
  #pages = 1;

  /**
   * @typedef {{ after: string | null }} Cursor   null for the first page
   *
   * @typedef {{ items: T[], next: string | null }} Page
   *
   * @param {(cursor: Cursor, signal: AbortSignal) => Promise<Page>} read reads one page
   */
  constructor(read) {
    this.#read = read;
  }

  /** Ask for one page more from now on. */
  extend() {
    this.#pages += 1;
  }

  /**
   * Everything read so far, as it is now.
   *
   * @param {AbortSignal} signal
   * @returns {Promise<{ items: T[], hasMore: boolean }>}
   */
  async fetch(signal) {
    const items = [];
    /** @type {string | null} */
    let after = null;
    for (let page = 0; page < this.#pages; page++) {
      /** @type {Page} */
      const answer = await this.#read({ after }, signal);
      items.push(...answer.items);
      after = answer.next;
      if (after === null) break;
    }
    return { items, hasMore: after !== null };
  }
}
