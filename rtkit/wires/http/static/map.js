// Map of places: what a property holds and, as further layers, what other properties of the page hold.
// A point or a region drawn on it, by pointer or by keys, is a SET of a marker or of an area.
import {Widget, drawn, make, scrolled, short} from "./widgets.js";
import {child, isVector, itemTexts, read, write} from "./values.js";

// What a map says; a page in another language puts its own in their place.
export const mapWords = {
  set: "Set", point: "Point", region: "Region", done: "Done",
  pointHint: "Click, or move the mark with the arrow keys (with Shift in larger steps) and press Enter. Escape ends.",
  regionHint: "Click the corners, or move the mark with the arrow keys and press Enter at each; then Done. Escape ends.",
  at: (x, y) => `mark at ${x}, ${y}`, corners: (count) => `${count} corners`, sent: (name) => `${name} is set`,
  drawing: "Map: arrow keys move the mark, Enter places it",
};

const STEP = 0.1, WIDE_STEP = 1;
const MOST_LISTED = 50, MOST_NAMED = 4, MARK_PX = 8, PAINT_MS = 100;
const rounded = (number) => +number.toFixed(2);
const isOutline = (value) => Array.isArray(value) && value.length > 2 && value.every((each) => isVector(each) && each.length > 1);

// The places in a value: markers wherever they are, a vector as a pose, a list of vectors as an outline, and
// where a behaviour leads that runs.
function placesIn(value, name) {
  if (isVector(value)) return value.length > 1 ? [{at: value, name}] : [];
  if (isOutline(value)) return [{outline: value, name}];
  if (Array.isArray(value)) return value.flatMap((each) => placesIn(each, name));
  if (!value?.children || (value.attributes.state ?? "running") !== "running") return [];
  const isTarget = value.name === "target";
  if (!value.children.some((each) => ["location", "region"].includes(each.name))) return value.children.flatMap((each) => placesIn(each, name));
  const leaf = (key) => child(value, key)?.leaf ?? undefined;
  const at = leaf("location"), region = leaf("region");
  const told = {name: leaf("name") ?? leaf("id") ?? leaf("type") ?? (isTarget ? name : ""), type: leaf("type"), frame: leaf("frame"), isTarget};
  const found = isVector(at) && at.length > 1 ? [{...told, at}] : [];
  return isOutline(region) ? [{...told, outline: region}, ...found] : found;
}

// The middle of an area, by its corners.
export function middleOf(corners) {
  let twice = 0, x = 0, y = 0;
  for (const [index, [ax, ay]] of corners.entries()) {
    const [bx, by] = corners[(index + 1) % corners.length], cross = ax * by - bx * ay;
    twice += cross; x += (ax + bx) * cross; y += (ay + by) * cross;
  }
  if (Math.abs(twice) > 1e-9) return [x / (3 * twice), y / (3 * twice)];
  return [0, 1].map((axis) => corners.reduce((sum, each) => sum + each[axis], 0) / corners.length);
}

const leafOf = (name, leaf) => ({name, attributes: {}, children: [], leaf});

// A marker for one point, or, with more corners, for somewhere in a region: its middle, its extent, and its corners.
export function markerOf(corners, frame, old) {
  const place = corners.length > 1 ? middleOf(corners).map(rounded) : corners[0];
  const before = child(old, "location")?.leaf;
  const extent = [0, 1].map((axis) => rounded(Math.max(...corners.map((each) => each[axis])) - Math.min(...corners.map((each) => each[axis]))));
  const region = corners.length > 1 ? [leafOf("size", extent), leafOf("region", corners)] : [];
  const changed = ["location", "region", ...(region.length ? ["size"] : [])];
  const kept = (old?.name === "marker" ? old.children : []).filter((each) => !changed.includes(each.name));
  const located = isVector(before) ? [...place, ...before.slice(2)] : place;
  const framed = frame && !kept.some((each) => each.name === "frame") ? [leafOf("frame", frame)] : [];
  return {name: "marker", attributes: {}, children: [leafOf("location", located), ...framed, ...region, ...kept], leaf: null};
}

class MapView extends Widget {
  draw(body) {
    this.layers = new Map(itemTexts(this.is.layers ?? "").map((each) => [String(read(each)), null]));
    this.corners = [];
    this.tool = "";
    this.view = drawn("svg", {class: "map", role: "img", "aria-labelledby": `${this.id}-name`});
    this.list = make("ul");
    body.append(this.view, ...(this.source.isReadOnly ? [] : [this.tools()]), this.list);
    this.seenBy = new IntersectionObserver(([last]) => {
      this.isSeen = last.isIntersecting;
      if (this.isSeen) this.redraw();
    });
    this.seenBy.observe(body);
    this.view.addEventListener("click", (event) => this.click(event));
    this.view.addEventListener("keydown", (event) => this.key(event));
  }

  tools() {
    this.target = make("select", {"aria-label": mapWords.set});
    const button = (tool) => {
      const made = make("button", {type: "button", "aria-pressed": "false", "data-tool": tool}, mapWords[tool]);
      made.addEventListener("click", () => this.arm(this.tool === tool ? "" : tool));
      return made;
    };
    this.buttons = [button("point"), button("region")];
    this.finish = make("button", {type: "button", hidden: true}, mapWords.done);
    this.finish.addEventListener("click", () => this.finishDrawing());
    this.hint = make("output", {"aria-live": "polite"});
    this.bar = make("span", {class: "tools", hidden: true}, make("label", {}, `${mapWords.set} `, this.target), ...this.buttons, this.finish, this.hint);
    return this.bar;
  }

  // What on this page takes a marker or an area, as far as its values tell.
  takers() {
    const isTaker = (each) => {
      const given = (each.gui?.children ?? []).filter(({attributes}) => attributes.argument === "true");
      const takesMarker = given.length === 1 && given[0].attributes.type === "marker";
      return each.is && !each.readOnly && each !== this && !each.parentElement.closest("rt-button") && (each.is.access ?? "rw").includes("w") &&
        (each.is.type === "marker" || each.value?.name === "marker" || isOutline(each.value) || (each.is.kind === "button" && takesMarker));
    };
    return [...(this.closest("rt-panel")?.querySelectorAll("[data-kind]") ?? [])].filter(isTaker);
  }

  offer() {
    if (!this.bar || this.bar.contains(document.activeElement)) return;
    const names = this.takers().map((each) => each.is.name), known = [...this.target.options].map((each) => each.value);
    this.bar.hidden = !names.length;
    if (names.join() !== known.join()) this.target.replaceChildren(...names.map((each) => new Option(each, each)));
    if (!names.length && this.tool) this.arm("");
  }

  arm(tool) {
    this.tool = tool;
    this.corners = [];
    for (const each of this.buttons) each.setAttribute("aria-pressed", String(each.dataset.tool === tool));
    this.finish.hidden = tool !== "region";
    this.finish.disabled = true;
    this.hint.textContent = tool ? mapWords[`${tool}Hint`] : "";
    this.view.setAttribute("role", tool ? "application" : "img");
    if (tool) {
      const {low, size} = this.seen;
      this.mark = [rounded(low[0] + size[0] / 2), rounded(-low[1] - size[1] / 2)];
      this.view.setAttribute("tabindex", "0");
      this.view.setAttribute("aria-label", mapWords.drawing);
      this.view.removeAttribute("aria-labelledby");
      this.view.focus();
    } else {
      this.view.removeAttribute("tabindex");
      this.view.removeAttribute("aria-label");
      this.view.setAttribute("aria-labelledby", `${this.id}-name`);
    }
    this.redraw();
  }

  click(event) {
    if (!this.tool) return;
    const {x, y} = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.view.getScreenCTM().inverse());
    this.place([rounded(x), rounded(-y)]);
  }

  key(event) {
    if (!this.tool) return;
    const step = event.shiftKey ? WIDE_STEP : STEP;
    const [dx, dy] = {ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step]}[event.key] ?? [0, 0];
    if (event.key === "Escape") { this.arm(""); this.buttons[0].focus(); }
    else if (event.key === "Backspace") this.corners.pop();
    else if (event.key === "Enter" || event.key === " ") this.place(this.mark);
    else if (!dx && !dy) return;
    else {
      this.mark = [rounded(this.mark[0] + dx), rounded(this.mark[1] + dy)];
      this.hint.textContent = mapWords.at(...this.mark);
    }
    event.preventDefault();
    event.stopPropagation();
    this.redraw();
  }

  place(corner) {
    this.mark = corner;
    this.corners.push(corner);
    this.finish.disabled = this.corners.length < 3;
    if (this.tool === "point") this.finishDrawing();
    else this.hint.textContent = `${mapWords.corners(this.corners.length)}, ${mapWords.at(...corner)}`;
    this.redraw();
  }

  async finishDrawing() {
    const taker = this.takers().find((each) => each.is.name === this.target.value);
    const corners = this.corners;
    if (!taker || !corners.length) return;
    const isArea = isOutline(taker.value) && corners.length > 2;
    const wanted = isArea ? corners : markerOf(corners, this.is.frame, taker.value);
    this.arm("");
    this.corners = corners;
    this.redraw();
    this.buttons[0].focus();
    try {
      await this.source.set(taker.is.name, write(wanted));
      this.problem.textContent = "";
      this.hint.textContent = mapWords.sent(taker.is.name);
    } catch (error) {
      this.problem.textContent = error.message;
    }
  }

  lock(isLocked) {
    for (const each of [this.target, ...(this.buttons ?? [])].filter(Boolean)) each.disabled = isLocked;
    if (isLocked && this.tool) this.arm("");
  }

  display(value) {
    this.own = value;
    this.redraw();
  }

  overlay(name, text, told) {
    if (!this.layers.has(name)) return;
    this.layers.set(name, told.code ? null : read(text));
    this.redraw();
  }

  // Now and then, whatever has come meanwhile, and only where somebody sees it.
  redraw() {
    if (!this.isSeen || this.due) return;
    const late = PAINT_MS - (performance.now() - (this.painted ?? -PAINT_MS));
    this.due = setTimeout(() => requestAnimationFrame(() => { this.due = undefined; this.paint(); }), Math.max(0, late));
  }

  disconnectedCallback() {
    this.seenBy?.disconnect();
    clearTimeout(this.due);
    this.isSeen = false;
  }

  found() {
    const named = (name) => (/\.location$/.test(name) ? name.replace(/\.location$/, "").split("/") : name.split(".")).pop();
    const all = [[this.is.name ?? "", this.own], ...this.layers].filter(([, value]) => value !== undefined && value !== null);
    // What is in another frame has no place on this map.
    const isHere = ({frame}) => !frame || !this.is.frame || frame === this.is.frame;
    return all.flatMap(([name, value]) => placesIn(value, named(name))).filter(isHere);
  }

  paint() {
    this.painted = performance.now();
    const found = this.found(), places = found.filter((each) => each.at), outlines = found.filter((each) => each.outline);
    if (!this.tool) this.frameView([[0, 0], ...places.map((each) => each.at), ...outlines.flatMap((each) => each.outline), ...this.corners]);
    const named = new Map();
    for (const {name} of places) named.set(name, (named.get(name) ?? 0) + 1);
    for (const each of places) each.isOneOfMany = named.get(each.name) > MOST_NAMED;
    const {low, size} = this.seen, {clientWidth, clientHeight} = this.view;
    // Marks are of one size on the screen, whatever the map shows.
    const unit = clientWidth ? MARK_PX * Math.max(size[0] / clientWidth, size[1] / clientHeight) : Math.max(...size) / 40;
    this.view.setAttribute("viewBox", [...low, ...size].join(" "));
    this.view.replaceChildren(drawn("path", {d: `M${low[0]} 0h${size[0]}M0 ${low[1]}v${size[1]}`, class: "axis"}),
      ...outlines.flatMap((each) => this.outline(each, unit)), ...places.flatMap((each) => this.spot(each, unit)), ...this.sketch(unit));
    this.shorten();
    const line = ({at, name, type}) => [name, type === name ? "" : type].filter(Boolean).join(", ") + `: ${at.map(short).join(" ")}`;
    this.list.replaceChildren(...places.slice(0, MOST_LISTED).map((each) => make("li", {}, line(each))));
    scrolled(this.list);
    this.offer();
  }

  frameView(points) {
    const xs = points.map((each) => each[0]), ys = points.map((each) => -each[1]);
    const low = [Math.min(...xs) - 0.5, Math.min(...ys) - 0.5];
    this.seen = {low, size: [Math.max(...xs) + 0.5 - low[0], Math.max(...ys) + 0.5 - low[1]]};
  }

  outline({outline, name}, unit) {
    const [x, y] = middleOf(outline);
    const label = drawn("text", {x, y: -y, "text-anchor": "middle", "font-size": unit * 1.5, class: "area-name"}, String(name ?? ""));
    return [drawn("polygon", {points: outline.map(([a, b]) => `${a},${-b}`).join(" "), class: "area"}), label];
  }

  spot({at, name, isTarget, isOneOfMany}, unit) {
    const {low, size} = this.seen, turn = at.length === 6 ? -at[5] * 180 / Math.PI : 0;
    const shape = at.length === 6 ? `M${unit * 1.5} 0L${-unit} ${unit}L${-unit} ${-unit}Z`
      : `M${unit} 0L0 ${unit}L${-unit} 0L0 ${-unit}Z`;
    const isRight = at[0] > low[0] + size[0] / 2;
    const label = drawn("text", {x: at[0] + (isRight ? -1.5 : 1.5) * unit, y: -at[1] - unit,
      "text-anchor": isRight ? "end" : "start", "font-size": unit * 1.7}, String(name ?? ""));
    const mark = isTarget ? drawn("circle", {cx: at[0], cy: -at[1], r: unit * 1.3, class: "goal"})
      : drawn("path", {d: shape, transform: `translate(${at[0]} ${-at[1]}) rotate(${turn})`});
    return isOneOfMany ? [mark] : [mark, label];
  }

  // What is being drawn, or was drawn last.
  sketch(unit) {
    const dots = this.corners.map(([x, y]) => drawn("circle", {cx: x, cy: -y, r: unit / 2, class: "corner"}));
    const ring = this.corners.length > 1 ? [drawn("polygon", {points: this.corners.map(([x, y]) => `${x},${-y}`).join(" "), class: "drawn"})] : [];
    if (!this.tool) return [...ring, ...dots];
    const [x, y] = [this.mark[0], -this.mark[1]], arm = unit * 1.6;
    return [...ring, ...dots, drawn("path", {d: `M${x - arm} ${y}h${2 * arm}M${x} ${y - arm}v${2 * arm}`, class: "cross"})];
  }

  // What is longer than the map ends in dots; it is told whole below the map, and to who points there.
  shorten() {
    const {low, size} = this.seen;
    for (const each of this.view.querySelectorAll("text:not(.area-name)")) {
      const x = Number(each.getAttribute("x"));
      const room = each.getAttribute("text-anchor") === "end" ? x - low[0] : low[0] + size[0] - x;
      const whole = each.textContent;
      let end = Math.ceil(whole.length * room / (each.getComputedTextLength?.() || 1));
      if (end > whole.length) continue;
      do each.textContent = `${whole.slice(0, end)}…`; while (each.getComputedTextLength() > room && --end > 0);
      each.append(drawn("title", {}, whole));
    }
  }
}
customElements.define("rt-map", MapView);
