/** The paper's figures of a sweep, as the service draws them; drawn once they are looked at. */
import { at, element } from "../parts/element.js";

const FORMS = ["png", "svg", "pdf", "csv"];

/** @import { Field, View } from "../parts/view.js" */

export class PaperFigures {
  #view;
  /** @type {[name: string, link: string][]} */
  #links = [];

  /** @param {View<{ figures: Field<boolean> }>} view */
  constructor(view) {
    this.#view = view;
    const details = at("paper-figures", HTMLDetailsElement);
    details.open = view.get("figures");
    details.addEventListener("toggle", () => {
      if (details.open !== view.get("figures")) view.set({ figures: details.open });
      this.#draw();
    });
  }

  /**
   * @param {Record<string, string>} links of the sweep; those called "figure_4" are the figures it
   *   has runs for
   */
  show(links) {
    this.#links = Object.entries(links).filter(([name]) => name.startsWith("figure_"));
    at("paper-figures").hidden = this.#links.length === 0;
    this.#draw();
  }

  #draw() {
    const body = at("paper-figures-body");
    if (!this.#view.get("figures") || body.childElementCount > 0) return;
    body.append(...this.#links.map(([name, link]) => figure(name.split("_")[1], link)));
  }
}

/**
 * @param {string} number
 * @param {string} link
 * @returns {HTMLElement}
 */
function figure(number, link) {
  const address = (/** @type {string} */ form) => link.replace(/\w+$/, form);
  const picture = element("img", {
    src: address("svg"),
    alt: `Figure ${number} of the paper, drawn from this sweep's runs`,
    loading: "lazy",
    onerror: () => picture.replaceWith(element("p", { class: "muted" }, "It cannot be drawn yet.")),
  });
  const downloads = FORMS.map((form) =>
    element(
      "a",
      { href: address(form), download: true, "aria-label": `Figure ${number} as ${form.toUpperCase()}` },
      form.toUpperCase(),
    ),
  );
  const caption = element("figcaption", { class: "downloads" }, `Figure ${number}`, ...downloads);
  return element("figure", { class: "paper-figure" }, caption, picture);
}
