// Widgets of live properties, as custom elements. They know nothing of HTTP: a source gives them
// what they need, {get(target), set(target, text), address(target)}, the first two as promises.
// All that a service says is shown as text, and never run.

import {child, isVector, itemTexts, read, write} from "./values.js";

const SVG = "http://www.w3.org/2000/svg";
// What widgets say; a page in another language puts its own in their place.
export const words = {
  alarm: "▲ alarm", warn: "△ warning", bad: "✕ bad", uncertain: "? uncertain", stale: "◷ stale", gone: "⊘ gone", round: "↻ above",
  on: "on", off: "off", stop: "Stop", stopOf: (name) => `Stop ${name}`, progressOf: (name) => `Progress of ${name}`,
  joystick: "Joystick: arrow keys steer while they are held", within: (low, high, seconds) => `${low} … ${high} in ${seconds} s`,
  noPicture: (name) => `${name}: no picture yet`, picture: (name, width, height) => `${name}, ${width} by ${height}`,
  notPicture: (bytes) => `no picture: ${bytes} bytes`, numbers: (count, low, high) => `${count} numbers from ${low} to ${high}`,
  component: (name) => `Component of ${name}`, service: "the service",
};
const KEPT_S = 60;
let ids = 0;

export function make(tag, attributes = {}, ...content) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes))
    if (value !== undefined && value !== false) made.setAttribute(key, value === true ? "" : value);
  made.append(...content.filter((each) => each !== undefined));
  return made;
}

export function drawn(tag, attributes = {}, ...content) {
  const made = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...content);
  return made;
}

export const short = (number) => write(Number.isInteger(number) ? number : Math.abs(number) >= 1e6 && Math.abs(number) < 1e15
  ? Math.round(number) : +number.toPrecision(6));

// A value as people read it: a text without its quotes, numbers not longer than needed.
export function shown(value, text) {
  if (typeof value === "number") return short(value);
  if (isVector(value)) return value.map(short).join("  ");
  return typeof value === "string" ? value : text;
}

const LONG = 200;
// What is longer than its place is scrolled, by keys too. A look at that costs a layout: short texts need none.
export function scrolled(element) {
  if (element.textContent.length < LONG) return;
  if (element.scrollHeight > element.clientHeight) element.tabIndex = 0;
  else element.removeAttribute("tabindex");
}

export class Widget extends HTMLElement {
  // Begins to draw one property; called once, before any value is shown.
  begin(gui, source) {
    this.gui = gui;
    this.source = source;
    this.is = gui.attributes;
    this.readOnly = this.is.access === "r" || source.isReadOnly === true;
    this.id ||= `rt-${++ids}`;
    this.dataset.kind = this.is.kind;
    this.dataset.name = this.is.name ?? "";
    this.title = this.is.doc ?? "";
    const name = this.is.label ?? (this.is.name ?? "").split(".").pop();
    this.caption = make("span", {class: "name", id: `${this.id}-name`}, name);
    this.body = make("span", {class: "body"});
    this.state = make("span", {class: "state"});
    this.problem = make("span", {class: "problem", role: "alert"});
    this.append(this.caption, this.body, make("span", {class: "unit"}, this.is.unit ?? ""),
                this.state, this.problem);
    this.draw(this.body);
    if (this.is.round) this.state.textContent = words[this.dataset.state = "round"];
    // What an empty widget shows is no value: it is seen once the first one has come.
    const isValue = this.is.kind !== "button" && this.is.argument !== "true" && !this.is.round;
    this.toggleAttribute("data-waits", isValue && (this.is.access ?? "").includes("r"));
  }

  draw(body) {
    this.out = make("output", {"aria-labelledby": `${this.id}-name`});
    body.append(this.out);
  }

  // Shows a value; `told` is what came with it: quality, and the code of what is no longer there, and why.
  show(text, told = {}) {
    if (this.is.round) return;  // it leads back to a service that is shown: nothing of it is shown again
    this.removeAttribute("data-waits");
    this.text = text;
    this.told = told;
    this.value = told.isRaw ? text : read(text);
    const severity = this.severity();
    const state = told.code ? "gone" : told.quality && told.quality !== "good" ? told.quality : severity;
    this.dataset.state = state;
    this.state.textContent = words[state] ?? "";
    if (told.why) this.problem.textContent = told.why;
    if (Boolean(told.code) !== Boolean(this.isGone)) this.lock(this.isGone = Boolean(told.code));
    if (!this.isHeld && !this.isLate(text)) this.display(this.value, text);
  }

  isLate() { return false; }

  display(value, text) {
    this.out.textContent = shown(value, text);
    scrolled(this.out);
  }

  severity() {
    const numbers = [this.value].flat().filter((each) => typeof each === "number");
    for (const word of ["alarm", "warn"]) {
      const limits = this.is[word] && read(this.is[word]);
      if (limits && numbers.some((each) => !(each >= limits[0] && each <= limits[1]))) return word;
    }
    return "";
  }

  lock(isLocked) {
    for (const each of this.body.querySelectorAll("input, textarea, select, button"))
      each.disabled = isLocked || this.readOnly;
  }

  // Sends the newest wish; those that come while one is on its way take the place of each other.
  async send(text, below = "") {
    this.wish = [below, text];
    this.wished = text;
    this.isSettling = true;
    clearTimeout(this.settled);
    if (this.isSending) return;
    this.isSending = true;
    while (this.wish) {
      const [where, wanted] = this.wish;
      this.wish = null;
      try {
        await this.source.set(this.is.name + where, wanted, this.held);
        this.problem.textContent = "";
      } catch (error) {
        this.problem.textContent = error.message;
      }
    }
    this.isSending = false;
    // Where the service made something else of it, or refused, no event may come.
    this.settled = setTimeout(() => {
      this.isSettling = false;
      if (!this.isHeld && this.text !== undefined) this.display(this.value, this.text);
    }, 300);
  }

  input(attributes, tag = "input") {
    const made = make(tag, {"aria-labelledby": `${this.id}-name`, disabled: this.readOnly, ...attributes});
    made.autocomplete = "off";
    return made;
  }
}

class TextField extends Widget {
  draw(body) {
    this.field = body.appendChild(this.made(this.is.type === "text"));
  }

  // A text may have several lines: a field of one line would lose their ends.
  made(isLong) {
    const field = isLong ? this.input({rows: 3, spellcheck: false}, "textarea")
      : this.input({type: this.is.kind === "number" ? "number" : "text", step: this.is.step ?? "any",
                    min: this.is.min, max: this.is.max});
    field.addEventListener("input", () => { this.isHeld = true; });
    field.addEventListener("change", () => { this.isHeld = false; this.send(this.wanted()); });
    field.addEventListener("keydown", (event) => { if (event.key === "Escape") this.leave(); });
    field.addEventListener("blur", () => this.leave());
    return field;
  }

  leave() {
    this.isHeld = false;
    if (this.text !== undefined) this.display(this.value, this.text);
  }

  wanted() {
    return this.is.type === "string" ? write(this.field.value) : this.field.value;
  }

  display(value, text) {
    const wanted = typeof value === "string" && this.is.type !== "any" ? value : text;
    if (wanted.includes("\n") && this.field.matches("input")) {
      const field = this.made(true);
      this.field.replaceWith(field);
      this.field = field;
    }
    this.field.value = wanted;
  }
}

class Slider extends Widget {
  draw(body) {
    const low = Number(this.is.min ?? 0), high = Number(this.is.max ?? 1);
    const step = this.is.step ?? (this.is.type === "integer" ? 1 : (high - low) / 200);
    this.field = this.input({type: "range", min: low, max: high, step});
    this.out = make("output", {for: this.field.id});
    this.needle = drawn("line", {x1: 12, y1: 12, x2: 12, y2: 3});
    const dial = drawn("svg", {viewBox: "0 0 24 24", class: "dial", "aria-hidden": "true"},
      drawn("circle", {cx: 12, cy: 12, r: 10}), this.needle);
    this.field.addEventListener("input", () => {
      this.isHeld = true;
      this.tell(this.field.value);
      this.send(this.field.value);
    });
    for (const end of ["change", "blur", "pointerup"])
      this.field.addEventListener(end, () => { this.isHeld = false; });
    body.append(...(this.is.kind === "knob" ? [dial] : []), this.field, this.out);
  }

  // Values of wishes before the newest one come back: they must not take it away from the next key.
  isLate(text) { return this.isSettling && text !== this.wished; }

  tell(text) {
    this.out.textContent = shown(Number(text), text);
    const part = (text - this.field.min) / (this.field.max - this.field.min);
    this.needle.setAttribute("transform", `rotate(${Math.min(1, Math.max(0, part)) * 270 - 135} 12 12)`);
  }

  display(value, text) {
    this.field.value = text;
    this.tell(text);
  }
}

class Toggle extends Widget {
  draw(body) {
    this.field = this.input({type: "checkbox", role: "switch"});
    this.out = make("output");
    this.field.addEventListener("change", () => this.send(String(this.field.checked)));
    body.append(this.field, this.out);
  }

  display(value) {
    this.field.checked = value === true;
    this.out.textContent = value === true ? words.on : words.off;
  }
}

class Choice extends Widget {
  draw(body) {
    this.field = make("select", {"aria-labelledby": `${this.id}-name`, disabled: this.readOnly});
    for (const each of itemTexts(this.is.choices ?? "()"))
      this.field.append(new Option(shown(read(each), each), each));
    this.field.addEventListener("change", () => this.send(this.field.value));
    body.append(this.field);
  }

  display(value, text) {
    if (![...this.field.options].some((each) => each.value === text))
      this.field.append(new Option(shown(value, text), text));
    this.field.value = text;
  }
}

class Vector extends Widget {
  draw() {
    this.fields = [];
  }

  build(labels) {
    this.fields = labels.map((label, index) => {
      const field = this.input({type: "number", step: this.is.step ?? "any", "aria-label": `${this.is.name} ${label}`,
                                min: this.is.min, max: this.is.max});
      field.addEventListener("input", () => { this.isHeld = true; });
      field.addEventListener("change", () => { this.isHeld = false; this.change(index, field.value); });
      field.addEventListener("blur", () => { this.isHeld = false; this.display(this.value, this.text); });
      return field;
    });
    this.body.replaceChildren(...this.fields.map((field, index) =>
      make("label", {}, make("span", {}, labels[index]), field)));
  }

  change(index, text) {
    this.send(text, `.${index}`);
  }

  numbers(value) {
    return value;
  }

  display(value, text) {
    const numbers = this.numbers(value);
    if (!isVector(numbers)) { this.body.textContent = text; this.fields = []; return; }
    if (numbers.length > MOST_PARTS) { this.body.replaceChildren(...outline(numbers)); this.fields = []; return; }
    const labels = this.is.labels ? itemTexts(this.is.labels) : ["x", "y", "z", "a", "b", "c"].slice(0, numbers.length);
    if (numbers.length !== this.fields.length)
      this.build(numbers.map((_, index) => labels[index] ?? String(index)));
    numbers.forEach((each, index) => { this.fields[index].value = short(each); });
  }
}

const MOST_PARTS = 12;

// Many numbers as one line, from the first to the last.
function outline(numbers) {
  const low = Math.min(...numbers), high = Math.max(...numbers);
  const points = numbers.map((each, index) =>
    `${(200 * index / (numbers.length - 1)).toFixed(1)},${high > low ? (57 - 54 * (each - low) / (high - low)).toFixed(1) : 30}`);
  return [drawn("svg", {viewBox: "0 0 200 60", preserveAspectRatio: "none", class: "plot", "aria-hidden": "true"},
    drawn("polyline", {points: points.join(" ")})),
    make("small", {}, words.numbers(numbers.length, short(low), short(high)))];
}

class Marker extends Vector {
  numbers(value) {
    const rest = (value?.children ?? []).filter((each) => each.name !== "location");
    this.title = rest.map((each) => `${each.name} ${write(each.leaf ?? "")}`).join("\n");
    return child(value, "location")?.leaf;
  }

  change(index, text) {
    this.send(text, `.location.${index}`);
  }

  display(value, text) {
    super.display(value, text);
    const told = ["name", "type", "id", "frame"].map((key) => child(value, key)?.leaf).filter(Boolean);
    this.out ??= make("output");
    this.out.textContent = told.join(" ");
    this.body.append(this.out);
  }
}

class Button extends Widget {
  draw(body) {
    this.given = new Map();
    const inputs = this.gui.children.filter((each) => each.attributes.argument === "true");
    for (const each of inputs) {
      const argument = {...each, attributes: {...each.attributes, access: "rw", ...SUITABLE[each.attributes.kind]}};
      const widget = widgetOf(argument);
      const asMarker = (text) => each.attributes.type === "marker" && text && !text.startsWith("<")
        ? `<marker><location>(${text.replace(/[()]/g, "")})</location></marker>` : text;
      const source = {isReadOnly: this.readOnly, set: async (name, text) => { this.given.set(name, asMarker(text)); widget.show(text, {isRaw: each.attributes.type === "marker"}); }};
      widget.begin(argument, source);
      if (each.attributes.default) widget.show(each.attributes.default);
      body.append(widget);
    }
    const name = this.caption.textContent;
    this.field = make("button", {type: "button", "aria-describedby": `${this.id}-name`, disabled: this.readOnly}, name);
    this.stop = make("button", {type: "button", hidden: true, disabled: this.readOnly, "aria-label": words.stopOf(name)}, words.stop);
    this.progress = make("progress", {hidden: true, "aria-label": words.progressOf(name)});
    this.out = make("output", {"aria-live": "polite"});
    this.field.addEventListener("click", () => this.start(inputs));
    this.stop.addEventListener("click", () => this.send("true", ".stop"));
    body.append(this.field, this.stop, this.progress, this.out);
  }

  start(inputs) {
    const names = inputs.map((each) => each.attributes.name).filter((each) => this.given.has(each));
    const only = inputs.length === 1 && !/^list/.test(inputs[0].attributes.type ?? "");
    if (only && names.length) this.send(this.given.get(names[0]));
    else this.send("", names.length ? "?" + names.map((each) =>
      `${each}=${encodeURIComponent(this.given.get(each))}`).join("&") : "");
  }

  display(value) {
    const state = value?.attributes?.state ?? "";
    const runs = state === "running";
    const progress = child(value, "progress")?.leaf;
    this.stop.hidden = this.progress.hidden = !runs;
    if (typeof progress === "number" && progress >= 0) {
      this.progress.max = progress > 1 ? 100 : 1;
      this.progress.value = progress;
    } else this.progress.removeAttribute("value");
    const result = child(value, "error") ?? child(value, "result") ?? child(value, "progress");
    const told = result && result.leaf !== null ? shown(result.leaf, write(result.leaf)) : "";
    this.out.textContent = `${state === "idle" ? "" : state} ${told}`.trim();
  }
}
// What an argument is given with, where the widget of its kind needs a value to begin with.
const SUITABLE = {vector: {kind: "text"}, marker: {kind: "text"}, map: {kind: "text"}, table: {kind: "text"},
                  tree: {kind: "text"}, label: {kind: "text"}};

class Joystick extends Widget {
  draw(body) {
    this.labels = this.is.labels ? itemTexts(this.is.labels) : ["x", "y"];
    const axes = this.is.axes ? itemTexts(this.is.axes) : this.labels.length === 6 ? ["x", "c"] : this.labels.slice(0, 2);
    this.axes = axes.map((each) => this.labels.indexOf(each));
    this.most = Math.min(Math.abs(Number(this.is.max ?? 1)), Math.abs(Number(this.is.min ?? -1)));
    this.knob = drawn("circle", {cx: 50, cy: 50, r: 14, class: "knob"});
    this.pad = make("div", {class: "pad", tabindex: this.readOnly ? undefined : 0, role: "application",
      "aria-labelledby": `${this.id}-name`,
      "aria-description": words.joystick});
    this.pad.append(drawn("svg", {viewBox: "0 0 100 100", "aria-hidden": "true"},
      drawn("circle", {cx: 50, cy: 50, r: 48}), drawn("path", {d: "M50 4V96M4 50H96"}), this.knob));
    this.out = make("output");
    body.append(this.pad, this.out);
    this.keys = new Set();
    if (this.readOnly) return;
    this.pad.addEventListener("pointerdown", (event) => { this.pad.setPointerCapture(event.pointerId); this.point(event); });
    this.pad.addEventListener("pointermove", (event) => { if (this.pad.hasPointerCapture(event.pointerId)) this.point(event); });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur"])
      this.pad.addEventListener(end, () => this.release());
    this.pad.addEventListener("keydown", (event) => this.key(event, true));
    this.pad.addEventListener("keyup", (event) => this.key(event, false));
    this.ended = new AbortController();
    const {signal} = this.ended;
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.release(); }, {signal});
    for (const end of ["blur", "pagehide"]) window.addEventListener(end, () => this.release(), {signal});
  }

  point(event) {
    const box = this.pad.getBoundingClientRect();
    this.steer(1 - 2 * (event.clientY - box.top) / box.height, 1 - 2 * (event.clientX - box.left) / box.width);
  }

  key(event, isDown) {
    if (!event.key.startsWith("Arrow")) return;
    event.preventDefault();
    if (isDown) this.keys.add(event.key); else this.keys.delete(event.key);
    const held = (name) => this.keys.has(`Arrow${name}`) ? 1 : 0;
    if (this.keys.size) this.steer(held("Up") - held("Down"), held("Left") - held("Right"));
    else this.release();
  }

  // Sends again and again while it is held: what moves by it stops when it hears nothing. A source may
  // see to that, too: with each value it gets the one at rest, and after which silence that counts.
  steer(ahead, left) {
    this.held = {rest: write(this.labels.map(() => 0)), after: Number(this.is.after ?? 0.5)};
    this.deflection = [ahead, left].map((each) => Math.min(1, Math.max(-1, each)));
    this.move();
    if (this.timer) return;
    this.timer = setInterval(() => this.move(), 1000 * Number(this.is.after ?? 0.5) / 4);
  }

  move() {
    const numbers = this.labels.map(() => 0);
    this.axes.forEach((axis, index) => { numbers[axis] = +(this.deflection[index] * this.most).toFixed(3); });
    this.send(write(numbers));
    this.place(numbers);
  }

  release() {
    if (!this.timer) return;
    clearInterval(this.timer);
    this.timer = null;
    this.keys.clear();
    this.held = undefined;
    this.send(write(this.labels.map(() => 0)));
  }

  lock(isLocked) {
    if (isLocked) this.release();
  }

  disconnectedCallback() {
    this.release();
    this.ended?.abort();
  }

  place(numbers) {
    const [ahead, left] = this.axes.map((axis) => (numbers[axis] ?? 0) / this.most);
    this.knob.setAttribute("cx", 50 - 34 * Math.min(1, Math.max(-1, left)));
    this.knob.setAttribute("cy", 50 - 34 * Math.min(1, Math.max(-1, ahead)));
  }

  display(value, text) {
    this.out.textContent = shown(value, text);
    if (isVector(value) && !this.timer) this.place(value);
  }
}

class Plot extends Widget {
  draw(body) {
    this.points = [];
    this.line = drawn("polyline", {points: ""});
    this.out = make("output");
    this.range = make("small");
    body.append(drawn("svg", {viewBox: "0 0 200 60", preserveAspectRatio: "none", class: "plot", "aria-hidden": "true"}, this.line),
                this.out, this.range);
    this.timer = setInterval(() => { if (this.points.length) this.trace(); }, 500);
  }

  disconnectedCallback() {
    clearInterval(this.timer);
  }

  display(value, text) {
    this.out.textContent = shown(value, text);
    if (typeof value !== "number") return;
    this.points.push([performance.now() / 1000, value]);
    this.trace();
  }

  trace() {
    const now = performance.now() / 1000;
    while (this.points.length > 1 && this.points[1][0] < now - KEPT_S) this.points.shift();
    const values = this.points.map((each) => each[1]);
    const low = Math.min(...values), high = Math.max(...values);
    const y = (value) => high > low ? 57 - 54 * (value - low) / (high - low) : 30;
    const x = (at) => Math.max(0, 200 - 200 * (now - at) / KEPT_S);
    const steps = this.points.flatMap(([at, value], index) =>
      [[x(at), y(value)], [index + 1 < this.points.length ? x(this.points[index + 1][0]) : 200, y(value)]]);
    this.line.setAttribute("points", steps.map(([a, b]) => `${a.toFixed(1)},${b.toFixed(1)}`).join(" "));
    this.range.textContent = words.within(short(low), short(high), KEPT_S);
  }
}

const KINDS_OF_IMAGES = [["ffd8ff", "image/jpeg"], ["89504e47", "image/png"], ["47494638", "image/gif"],
                         ["52494646", "image/webp"]];
function kindOf(raw) {
  const head = [...new Uint8Array(raw.slice(0, 4))].map((each) => each.toString(16).padStart(2, "0")).join("");
  return KINDS_OF_IMAGES.find(([begin]) => head.startsWith(begin))?.[1];
}

// A browser has six connections to an endpoint: one is for events, two at least for what is asked and set.
const MOST_STREAMS = 3;
const streams = new Set();

class Picture extends Widget {
  draw(body) {
    this.image = make("img", {alt: words.noPicture(this.is.name)});
    this.image.addEventListener("load", () => {
      this.image.alt = words.picture(this.is.name, this.image.naturalWidth, this.image.naturalHeight);
      this.problem.textContent = "";
    });
    this.image.addEventListener("error", () => { if (streams.has(this)) { this.end(); this.fetch(); } });
    body.append(this.image);
    this.seen = new IntersectionObserver(([last]) => {
      this.isSeen = last.isIntersecting;
      if (!this.isSeen) this.end(); else if (this.text !== undefined) this.display();
    });
    this.seen.observe(body);
  }

  // A change brings no picture along. What is seen is a stream of pictures; where there are too many, or
  // it shows none, each is fetched, one at a time.
  display() {
    if (!this.isSeen) return;
    if (streams.has(this)) { this.check(); return; }
    const address = streams.size < MOST_STREAMS && this.source.address?.(this.is.name);
    if (!address) { this.fetch(); return; }
    streams.add(this);
    this.image.src = `${address}?stream&every=0.05`;
  }

  // Browsers pass over what is no picture in a stream: soon after a change, its first bytes are looked at.
  check() {
    this.checked ??= setTimeout(async () => {
      const head = await this.source.get(`${this.is.name}?offset=0&length=4`, true).catch(() => null);
      this.checked = undefined;
      if (!streams.has(this) || head === null || kindOf(head)) return;
      this.end();
      this.fetch();
    }, 1000);
  }

  end() {
    if (streams.delete(this)) this.image.src = "data:,";
  }

  lock(isLocked) {
    if (isLocked) streams.delete(this);  // its stream has ended, too; the last picture stays
  }

  disconnectedCallback() {
    this.seen.disconnect();
    this.end();
  }

  async fetch() {
    this.isNew = true;
    if (this.isBusy) return;
    this.isBusy = true;
    while (this.isNew) {
      this.isNew = false;
      try {
        const raw = await this.source.get(this.is.name, true);
        const type = kindOf(raw);
        if (!type) throw new Error(words.notPicture(raw.byteLength));
        const old = this.image.src;
        this.image.src = URL.createObjectURL(new Blob([raw], {type}));
        await this.image.decode();
        URL.revokeObjectURL(old);
      } catch (error) {
        if (!streams.has(this)) this.problem.textContent = error.message;
      }
    }
    this.isBusy = false;
  }
}

class Table extends Widget {
  draw(body) {
    this.table = make("table", {"aria-labelledby": `${this.id}-name`});
    body.append(this.table);
  }

  display(value, text) {
    const rows = Array.isArray(value) ? value : [text];
    const labels = this.is.columns ? itemTexts(this.is.columns) : [];
    const head = labels.length ? [make("tr", {}, ...labels.map((each) => make("th", {scope: "col"}, each)))] : [];
    this.table.replaceChildren(...head, ...rows.slice(0, 200).map((row) => make("tr", {},
      ...[row].flat().map((each) => make("td", {}, shown(each, write(each)))))));
  }
}

class Tree extends Widget {
  display(value, text) {
    this.body.replaceChildren(value && value.name ? this.branch(value) : make("output", {}, text));
  }

  branch(element) {
    const given = Object.entries(element.attributes).map(([key, each]) => `${key}: ${each}`).join(", ");
    const leaf = element.leaf === null ? "" : shown(element.leaf, write(element.leaf));
    const told = [element.name, given, leaf].filter((each) => each !== "").join("  ");
    if (!element.children.length) return make("div", {}, told);
    return make("details", {open: true}, make("summary", {}, told), ...element.children.map((each) => this.branch(each)));
  }
}

// What was drawn for a <gui>: its widget or group, and the frame of its component.
const widgets = new WeakMap(), frames = new WeakMap();

export class Group extends HTMLElement {
  // Offers the component that a service brings along for this property or its type.
  frame(gui, source) {
    const address = source.component?.(gui);
    if (!address) return;
    const made = make("rt-frame");
    this.append(made);
    made.begin(gui, source, address);
    frames.set(gui, made);
  }

  begin(gui, source, depth = 2) {
    this.dataset.name = gui.attributes.name ?? "";
    const title = gui.attributes.label ?? (gui.attributes.name ?? "").split(".").pop();
    const id = `rt-${++ids}`;
    this.setAttribute("role", "group");
    if (depth === 2) this.frame(gui, source);
    if (title) {
      this.append(make(`h${Math.min(6, depth)}`, {id, title: gui.attributes.doc}, title));
      this.setAttribute("aria-labelledby", id);
    }
    for (const each of gui.children) {
      if (each.attributes.argument === "true") continue;
      const made = widgetOf(each);
      this.append(made);
      made.begin(each, source, depth + 1);
      widgets.set(each, made);
      this.frame(each, source);
      const below = each.children.filter((one) => one.attributes.argument !== "true");
      if (!(made instanceof Group) && below.length) {
        const group = make("rt-group");
        this.append(group);
        group.begin({attributes: {kind: "group", name: each.attributes.name}, children: below}, source, depth + 1);
      }
    }
  }
}

// Widgets as a component wants them drawn: its attributes stand for theirs, but for what a property is;
// its children, named from there, choose and order them.
export function dressed(gui, component) {
  const {name, type, access, argument, default: _, ...changed} = component.attributes;
  const made = {...gui, attributes: {...gui.attributes, ...changed}};
  if (!component.children.length) return made;
  const prefix = gui.attributes.name ? `${gui.attributes.name}.` : "", known = new Map();
  const note = (each) => { known.set(each.attributes.name, each); each.children.forEach(note); };
  gui.children.forEach(note);
  const wanted = component.children.map((each) => [known.get(prefix + each.attributes.name), each]);
  return {...made, children: wanted.filter(([found]) => found).map(([found, each]) => dressed(found, each))};
}

// All that is drawn of a panel, in its order; arguments of actions belong to their buttons.
const all = (gui) => [gui, ...gui.children.filter((each) => each.attributes.argument !== "true").flatMap(all)];
const own = (gui) => write({...gui, children: gui.children.filter((each) => each.attributes.argument === "true")});

// Panel of a service, or of a part of one.
export class Panel extends HTMLElement {
  draw(gui, source) {
    const group = make("rt-group");
    this.replaceChildren(group);
    this.known = null;
    this.root = gui.attributes.kind === "group" ? gui : {attributes: {kind: "group", name: ""}, children: [gui]};
    group.begin(this.root, source);
  }

  // Draws only those anew that are described in another way; where names have come or gone, all.
  redraw(gui, source) {
    const now = all(gui.attributes.kind === "group" ? gui : {attributes: {kind: "group", name: ""}, children: [gui]});
    const before = this.root ? all(this.root) : [];
    const isSame = (each, index) => each.attributes.name === now[index].attributes.name &&
      each.children.length === now[index].children.length && (own(each) === own(now[index]) || widgets.get(each)?.gui);
    if (before.length !== now.length || !before.every(isSame)) { this.draw(gui, source); return; }
    for (const [index, each] of before.entries()) {
      const old = widgets.get(each), made = own(each) === own(now[index]) ? old : widgetOf(now[index]);
      if (made === old) { widgets.set(now[index], old); if (frames.has(each)) frames.set(now[index], frames.get(each)); continue; }
      old.replaceWith(made);
      made.begin(now[index], source);
      widgets.set(now[index], made);
      if (old.text !== undefined) made.show(old.text, old.told);
      const frame = frames.get(each), wasOpen = Boolean(frame?.frame);
      frame?.remove();
      made.parentElement.frame(now[index], source);
      const newer = frames.get(now[index]);
      if (newer) made.after(newer);
      if (wasOpen) newer?.opener.click();
    }
    this.root = now[0];
    this.known = null;
  }

  // What shows a property, or, with `isBelow`, also what shows something that it is a part of.
  show(name, text, told) {
    this.known ??= this.shownBy();
    for (const each of this.known.get(name) ?? []) each.show(text, told);
    for (const each of this.known.get("rt-map")) each.overlay?.(name, text, told);
    for (const each of this.known.get("rt-frame")) each.pass(name, text);
  }

  // The widgets by the names that they show; it stays so until something is drawn anew.
  shownBy() {
    const found = new Map(["rt-map", "rt-frame"].map((each) => [each, [...this.querySelectorAll(each)]]));
    for (const each of this.querySelectorAll("[data-name]"))
      if (each.show && !each.parentElement.closest("rt-button")) found.set(each.dataset.name, [...(found.get(each.dataset.name) ?? []), each]);
    return found;
  }

  // Locks all while its service is not there: what is shown is what was known last.
  lock(isLocked) {
    this.toggleAttribute("data-lost", isLocked);
    for (const each of this.querySelectorAll("*")) each.lock?.(isLocked);
  }
}
customElements.define("rt-panel", Panel);

const ELEMENTS = {label: Widget, text: TextField, number: TextField, slider: Slider, knob: Slider, toggle: Toggle,
  button: Button, choice: Choice, vector: Vector, joystick: Joystick, plot: Plot, image: Picture,
  table: Table, marker: Marker, tree: Tree, group: Group};
const OTHERS = new Set(["panel", "frame"]);
for (const [kind, Element] of Object.entries(ELEMENTS))
  customElements.define(`rt-${kind}`, class extends Element {});

export function widgetOf(gui) {
  const {kind, type} = gui.attributes;
  const known = customElements.get(`rt-${kind}`) && !OTHERS.has(kind) ? kind : "label";
  return document.createElement(`rt-${known === "knob" && type === "boolean" ? "toggle" : known}`);
}
