/**
 * Markdown as data: what authors of tasks and learners write of them, in the part of CommonMark that
 * docstrings use. Nothing of it is ever HTML: what is not understood stays text.
 *
 * Unlike in CommonMark, an indented line is code right below a paragraph too ("Glossary:"), and
 * asterisks within words mark nothing ("2**3").
 */

/**
 * @typedef {{ kind: "text" | "code" | "strong" | "emphasis", text: string }
 *   | { kind: "link", text: string, address: string }} Span
 *
 * @typedef {{ kind: "paragraph" | "heading", spans: Span[] }
 *   | { kind: "code", text: string }
 *   | { kind: "list", isOrdered: boolean, items: Span[][] }} Block
 */

const SPAN =
  /`(?<code>[^`]+)`|(?<![\w*])\*\*(?<strong>[^\s*]|[^\s*].*?[^\s*])\*\*(?![\w*])|(?<![\w*])\*(?<emphasis>[^\s*]|[^\s*][^*]*?[^\s*])\*(?![\w*])|\[(?<text>[^\]]+)\]\((?<address>https?:\/\/[^\s)]+)\)/gsu;
const INDENTED = /^(?: {4}|\t)/u;
const ITEM = /^ {0,3}(?:[-*+]|(?<number>\d{1,9})[.)]) +(?=\S)/u;
const FENCE = /^ {0,3}(`{3,}|~{3,})/u;
const HEADING = /^ {0,3}#{1,6} +(?<text>.*?)(?: +#+)? *$/u;

/**
 * @param {string} text
 * @returns {Block[]}
 */
export function markdown(text) {
  const lines = text.replaceAll("\r\n", "\n").split("\n");
  /** @type {Block[]} */
  const blocks = [];
  while (lines.length > 0) {
    if (isBlank(lines[0])) lines.shift();
    else blocks.push(nextBlock(lines));
  }
  return blocks;
}

/**
 * Take the lines of a block from the front.
 *
 * @param {string[]} lines the first of them is not blank
 * @returns {Block}
 */
function nextBlock(lines) {
  const [first] = lines;
  const fence = first.match(FENCE)?.[1];
  if (fence !== undefined) return fenced(lines, fence);
  if (INDENTED.test(first)) return indented(lines);
  const heading = first.match(HEADING)?.groups;
  if (heading !== undefined) {
    lines.shift();
    return { kind: "heading", spans: spans(heading.text) };
  }
  return ITEM.test(first) ? list(lines) : { kind: "paragraph", spans: paragraph(lines) };
}

/**
 * @param {string[]} lines
 * @param {string} fence
 * @returns {Block}
 */
function fenced(lines, fence) {
  lines.shift();
  const end = lines.findIndex((line) => line.trim().startsWith(fence));
  const inside = lines.splice(0, end < 0 ? lines.length : end);
  lines.shift();
  return { kind: "code", text: inside.join("\n") };
}

/**
 * @param {string[]} lines
 * @returns {Block}
 */
function indented(lines) {
  const inside = takeWhile(lines, (line) => INDENTED.test(line) || isBlank(line));
  return { kind: "code", text: inside.map((line) => line.replace(INDENTED, "")).join("\n").trimEnd() };
}

/**
 * Items of one kind; the lines of an item that are not its first are indented, or follow at once.
 *
 * @param {string[]} lines
 * @returns {Block}
 */
function list(lines) {
  const isOrdered = isNumbered(lines[0]);
  /** @type {Span[][]} */
  const items = [];
  while (lines.length > 0 && ITEM.test(lines[0]) && isNumbered(lines[0]) === isOrdered) {
    lines[0] = lines[0].replace(ITEM, "");
    const first = /** @type {string} */ (lines.shift());
    const others = takeWhile(lines, (line) => !isBlank(line) && !ITEM.test(line));
    items.push(spans([first, ...others.map((line) => line.trim())].join(" ")));
    if (lines.length > 1 && isBlank(lines[0]) && ITEM.test(lines[1])) lines.shift();
  }
  return { kind: "list", isOrdered, items };
}

/**
 * @param {string[]} lines
 * @returns {Span[]}
 */
function paragraph(lines) {
  const first = /** @type {string} */ (lines.shift());
  const others = takeWhile(
    lines,
    (line) => ![INDENTED, ITEM, FENCE, HEADING].some((other) => other.test(line)) && !isBlank(line),
  );
  return spans([first, ...others].map((line) => line.trim()).join(" "));
}

/**
 * @param {string} text
 * @returns {Span[]}
 */
function spans(text) {
  /** @type {Span[]} */
  const found = [];
  let end = 0;
  for (const match of text.matchAll(SPAN)) {
    if (match.index > end) found.push({ kind: "text", text: text.slice(end, match.index) });
    found.push(spanOf(match.groups ?? {}));
    end = match.index + match[0].length;
  }
  if (end < text.length) found.push({ kind: "text", text: text.slice(end) });
  return found;
}

/**
 * @param {Record<string, string>} groups
 * @returns {Span}
 */
function spanOf({ code, strong, emphasis, text, address }) {
  if (code !== undefined) return { kind: "code", text: code };
  if (strong !== undefined) return { kind: "strong", text: strong };
  if (emphasis !== undefined) return { kind: "emphasis", text: emphasis };
  return { kind: "link", text, address };
}

/**
 * Take lines from the front.
 *
 * @param {string[]} lines
 * @param {(line: string) => boolean} belongs
 * @returns {string[]}
 */
function takeWhile(lines, belongs) {
  const end = lines.findIndex((line) => !belongs(line));
  return lines.splice(0, end < 0 ? lines.length : end);
}

/** @param {string} line */
function isNumbered(line) {
  return line.match(ITEM)?.groups?.number !== undefined;
}

/** @param {string} line */
function isBlank(line) {
  return line.trim() === "";
}
