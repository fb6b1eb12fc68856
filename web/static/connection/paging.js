/** A list of the service that is read page by page and kept as far as it was read. */
import { get } from "./api.js";

export class Listing {
  #path;
  #limit;
  #pages = 1;

  constructor(path, limit) {
    this.#path = path;
    this.#limit = limit;
  }

  /** Ask for one page more from now on. */
  extend() {
    this.#pages += 1;
  }

  /** Begin again at the first page. */
  restart() {
    this.#pages = 1;
  }

  /** Everything read so far, as it is now: { items, hasMore }. */
  async fetch(parameters, signal) {
    const items = [];
    let after = null;
    for (let page = 0; page < this.#pages; page++) {
      const query = { ...parameters, limit: this.#limit, after };
      const answer = await get(this.#path, query, signal);
      items.push(...answer.items);
      after = answer.next;
      if (after === null) break;
    }
    return { items, hasMore: after !== null };
  }
}
