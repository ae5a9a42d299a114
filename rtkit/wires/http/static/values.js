// Values of the Property Service: reads and writes their text.
// Numbers, booleans and texts are those of JavaScript, groups are arrays, elements objects
// {name, attributes, children, leaf}. What is no value stays the text that it was.

const ITEM = /[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?inf|nan/y;
const WORD = /[^\s()<>"{}]+/y;
const NAME = /[A-Za-z_][\w.-]*/y;
const ENTITIES = {amp: "&", lt: "<", gt: ">", quot: '"', apos: "'"};
const ESCAPES = {n: "\n", r: "\r", t: "\t", '"': '"', "\\": "\\"};
const DEEPEST = 64;

class Reader {
  constructor(text) {
    this.text = text;
    this.at = 0;
  }

  fail(expected) {
    throw new SyntaxError(`${this.at} expected ${expected}`);
  }

  match(pattern) {
    pattern.lastIndex = this.at;
    const found = pattern.exec(this.text);
    if (found) this.at = pattern.lastIndex;
    return found && found[0];
  }

  blanks() {
    this.match(/\s*/y);
  }

  item(depth = 0) {
    if (depth > DEEPEST) this.fail("less depth");
    const sign = this.text[this.at];
    if (sign === "(") return this.items(depth).map((each) => each.value);
    if (sign === "<") return this.element(depth);
    if (sign === '"') return this.string();
    const word = this.match(WORD);
    if (word === null) this.fail("a value");
    ITEM.lastIndex = 0;
    const number = ITEM.exec(word);
    if (number && number[0] === word)
      return Number(word.replace("inf", "Infinity").replace("nan", "NaN"));
    return word === "true" ? true : word === "false" ? false : word;
  }

  // Items of a group, each with its text.
  items(depth) {
    const found = [];
    this.at += 1;
    for (this.blanks(); this.text[this.at] !== ")"; this.blanks()) {
      const begin = this.at;
      const value = this.item(depth + 1);
      found.push({value, text: this.text.slice(begin, this.at)});
    }
    this.at += 1;
    return found;
  }

  string() {
    const found = this.match(/"(?:[^"\\]|\\(?:u\{[0-9a-fA-F]{1,6}\}|.))*"/y);
    if (found === null) this.fail("the end of a string");
    return found.slice(1, -1).replace(/\\(?:u\{([0-9a-fA-F]+)\}|(.))/g,
      (_, code, sign) => code ? String.fromCodePoint(parseInt(code, 16)) : ESCAPES[sign] ?? sign);
  }

  element(depth) {
    this.at += 1;
    const name = this.match(NAME) ?? this.fail("a name");
    const made = {name, attributes: {}, children: [], leaf: null};
    for (this.blanks(); !/[/>]/.test(this.text[this.at] ?? ">"); this.blanks()) {
      const key = this.match(NAME) ?? this.fail("an attribute");
      const raw = this.match(/\s*=\s*(?:"[^"]*"|'[^']*')/y) ?? this.fail("a value in quotes");
      made.attributes[key] = decoded(raw.replace(/^\s*=\s*/, "").slice(1, -1));
    }
    if (this.match(/\/>/y)) return made;
    if (!this.match(/>/y)) this.fail(">");
    const end = new RegExp(`</${name}\\s*>`, "y");
    while (!this.match(end)) {
      const blank = /\s*(?:<!--[^]*?-->\s*)*(?=<)/y;
      if (made.leaf === null && this.match(blank) !== null) {
        if (this.text[this.at + 1] === "/") { if (!this.match(end)) this.fail(`</${name}>`); break; }
        if (depth >= DEEPEST) this.fail("less depth");
        made.children.push(this.element(depth + 1));
      } else {
        const leaf = this.match(/[^<]+/y) ?? this.fail(`</${name}>`);
        made.leaf = read(decoded(leaf).trim());
      }
    }
    return made;
  }
}

const decoded = (text) => text.replace(/&(?:#x([0-9a-fA-F]+)|#(\d+)|(\w+));/g,
  (whole, hex, digits, name) => hex || digits
    ? String.fromCodePoint(parseInt(hex || digits, hex ? 16 : 10)) : ENTITIES[name] ?? whole);

export function read(text) {
  try {
    const reader = new Reader(text);
    reader.blanks();
    if (reader.at === text.length) return "";
    const value = reader.item();
    reader.blanks();
    return reader.at === text.length ? value : text;
  } catch {
    return text;
  }
}

// The texts of the items of a group, as they stand there.
export function itemTexts(text) {
  try {
    return new Reader(text.trim()).items(0).map((each) => each.text);
  } catch {
    return [];
  }
}

export function write(value) {
  if (typeof value === "number")
    return String(value).replace("Infinity", "inf").replace("NaN", "nan");
  if (typeof value === "boolean") return String(value);
  if (Array.isArray(value)) return `(${value.map(write).join(" ")})`;
  if (value && typeof value === "object") return escaped(value);
  return `"${String(value).replace(/["\\]/g, "\\$&").replace(/\n/g, "\\n").replace(/\r/g, "\\r")
    .replace(/\t/g, "\\t").replace(/[\x00-\x1f\x7f]/g, (sign) => `\\u{${sign.charCodeAt(0).toString(16)}}`)}"`;
}

const xml = (text) => text.replace(/[&<>"\n]/g, (sign) => `&#${sign.charCodeAt(0)};`);

const isWord = (leaf) => typeof leaf === "string" && /^[^\s()<>"{}]+$/.test(leaf) && read(leaf) === leaf;

function escaped({name, attributes = {}, children = [], leaf = null}) {
  const given = Object.entries(attributes).map(([key, text]) => ` ${key}="${xml(text)}"`).join("");
  const content = children.map(escaped).join("") + (leaf === null ? "" : xml(isWord(leaf) ? leaf : write(leaf)));
  return content ? `<${name}${given}>${content}</${name}>` : `<${name}${given}/>`;
}

export const child = (element, name) => element?.children?.find((each) => each.name === name);
export const isVector = (value) =>
  Array.isArray(value) && value.every((each) => typeof each === "number");
