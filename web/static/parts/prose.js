/** Markdown as elements: of headings, lists, code and marked words; text stays text. */
import { element } from "./element.js";

/** @import { Block, Span } from "../texts/markdown.js" */

const TAGS = /** @type {const} */ ({ code: "code", strong: "strong", emphasis: "em" });

/**
 * @param {Block[]} blocks
 * @returns {HTMLElement[]}
 */
export function prose(blocks) {
  return blocks.map(blockElement);
}

/**
 * @param {Block} block
 * @returns {HTMLElement}
 */
function blockElement(block) {
  if (block.kind === "code") return element("pre", { tabindex: "0" }, block.text);
  if (block.kind === "list") {
    const items = block.items.map((spans) => element("li", {}, ...spans.map(spanNode)));
    return element(block.isOrdered ? "ol" : "ul", {}, ...items);
  }
  const spans = block.spans.map(spanNode);
  if (block.kind === "heading") return element("p", { class: "prose-heading" }, ...spans);
  return element("p", {}, ...spans);
}

/**
 * @param {Span} span
 * @returns {Node | string}
 */
function spanNode(span) {
  if (span.kind === "text") return span.text;
  if (span.kind === "link") {
    return element("a", { href: span.address, rel: "noopener noreferrer" }, span.text);
  }
  return element(TAGS[span.kind], {}, span.text);
}
