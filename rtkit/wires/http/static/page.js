// The page of the HTTP endpoint: a panel of a service, or of a part of it, live by one stream of events.
import "./frames.js";
import "./map.js";
import {dressed, make} from "./widgets.js";
import {itemTexts, read, write} from "./values.js";

const element = (id) => document.getElementById(id);
// An address with user and password in it is none that may be fetched from; the origin has neither.
const at = (path) => `${location.origin}/ps${path}`;
const panel = element("panel");
const LATER_MS = 1000, LOOK_MS = 3000;
// What is looked at now and then, for no event tells of it: components that are used, mounts that are away.
const watched = new Map();
let stream = null, shown = null, again = 0, asked = 0;

async function fetched(path, options, isRaw) {
  const reply = await fetch(at(path), options);
  if (!reply.ok) throw Object.assign(new Error((await reply.text()).trim()), {isStranger: reply.status === 401});
  return isRaw ? reply.arrayBuffer() : reply.text();
}

class Source {
  constructor(service, components) {
    this.service = service;
    this.components = components;
  }

  get(target, isRaw) { return fetched(`/${this.service}/${target}`, {}, isRaw); }
  set(target, text) { return fetched(`/${this.service}/${target}`, {method: "PUT", body: text}); }
  address(target) { return at(`/${this.service}/${target}`); }

  // The component of a property itself, else what the GUI service has for its type.
  component({attributes: {name, type, forms}}) {
    if (has(forms, "html")) return at(`/${this.service}/${name && `${name}.`}gui.html`);
    const known = typed(type, this.components, "html");
    return known && at(known);
  }
}

// What the GUI service has, by type: one behind this endpoint, or mounted in the shown service.
async function components(services, service, gui) {
  const other = services.find((each) => /(^|\/)gui$/.test(each));
  const group = gui.children.find((each) => typesOf(each.attributes.type).includes("gui"));
  const root = other ? `/${other}/` : group ? `/${service}/${group.attributes.name}.` : "";
  const listing = `${root}properties?all=1`, text = root ? await fetched(listing) : "";
  if (root) watched.set(listing, text);
  return {root, names: new Set(itemTexts(text))};
}

const has = (forms, form) => Boolean(forms) && itemTexts(forms).includes(form);

const typesOf = (type) => type?.startsWith("(") ? itemTexts(type).map(read) : [(type ?? "").replace(/[[<].*/, "")];

// The address of a component for one of the types, if there is any.
function typed(type, {root, names}, form) {
  const known = typesOf(type).find((each) => names.has(`${each}.${form}`));
  return known && `${root}${known}.${form}`;
}

// The widgets of a service: as it says, or of each of its names where it does not know.
async function description(service, part) {
  try {
    return await fetched(`/${service}/${part ? `${part}.` : ""}gui`);
  } catch (error) {
    if (part || !/^(unknown|syntax|bad-parameter)/.test(error.message)) throw error;
  }
  const names = itemTexts(await fetched(`/${service}/properties`));
  const each = await Promise.all(names.map(async (name) => {
    const told = await fetched(`/${service}/${name}.gui`).then(read, () => ({attributes: {kind: "label"}, children: []}));
    return {name: "gui", children: told.children, attributes: {...told.attributes, name}};
  }));
  return write({name: "gui", attributes: {kind: "group", name: ""}, children: each});
}

// What is drawn in place of the usual widgets: the component of a property itself, else of its type, as <gui>.
async function dressedBy(gui, service, known, used) {
  const {name, type, forms} = gui.attributes;
  const ofType = typed(type, known, "text");
  const path = has(forms, "text") ? `/${service}/${name && `${name}.`}gui.text` : ofType;
  const children = await Promise.all(gui.children.map((each) => dressedBy(each, service, known, used)));
  const made = {...gui, children};
  if (!path) return made;
  const component = read(await fetched(path));
  if (path === ofType) used.add(`${path}.meta.revision`);
  return component?.name === "gui" ? dressed(made, component) : made;
}

const texts = (paths) => Promise.all([...paths].map((each) => fetched(each).catch(() => "")));

async function look() {
  const turn = asked, known = document.hidden ? [] : [...watched];
  // Whoever is stopped ends no stream: what is shown may be old.
  if (stream?.readyState === EventSource.OPEN && !document.hidden)
    await fetched("", {signal: AbortSignal.timeout(LOOK_MS)}).catch(() => { if (turn === asked) lost("no answer"); });
  const now = await texts(known.map(([path]) => path));
  if (turn === asked && known.some(([, before], index) => before !== now[index])) await open();
  setTimeout(look, LOOK_MS);
}

const all = (gui) => [gui, ...gui.children.flatMap(all)];

function say(text, isLost = false) {
  element("state").textContent = text;
  element("state").dataset.lost = isLost;
  panel.lock(isLost);
}

async function open() {
  const turn = ++asked;
  clearTimeout(again);
  watched.clear();
  stream?.close();
  try {
    const services = itemTexts(await fetched(""));
    const [service, part] = wanted(services);
    list(services, service);
    if (!service) { panel.replaceChildren(); say(services.length ? "Choose a service." : "There is no service."); return; }
    const text = await description(service, part);
    const known = await components(services, service, read(text));
    const used = new Set(), gui = await dressedBy(read(text), service, known, used);
    if (turn !== asked) return;
    const key = `${service} ${write(gui)} ${[...known.names]}`;
    if (shown !== key) {
      const focused = document.activeElement?.closest("[data-name]")?.dataset.name;
      panel.draw(gui, new Source(service, known));
      shown = key;
      if (focused) panel.querySelector(`[data-name="${CSS.escape(focused)}"] :is(input, textarea, select, button, [tabindex])`)?.focus();
    }
    document.title = `${[service, part].filter(Boolean).join("/")} – panel`;
    element("name").textContent = document.title.replace(" – panel", "");
    listen(service, part, gui);
    const away = all(gui).filter((each) => each.attributes.away).map((each) => `/${service}/${each.attributes.name}.gui`);
    const now = await texts(used);
    if (turn === asked) for (const [index, each] of [...used].entries()) watched.set(each, now[index]);
    if (turn === asked) for (const each of away) watched.set(each, "");
  } catch (error) {
    lost(error.message, error.isStranger);
  }
}

function wanted(services) {
  const given = decodeURIComponent(location.pathname === "/" ? location.hash.slice(1)
    : `${location.pathname.slice(4)}/${location.hash.slice(1)}`).replace(/\/$/, "");
  const service = services.filter((each) => given === each || given.startsWith(`${each}/`))
    .sort((a, b) => b.length - a.length)[0];
  if (service) return [service, given.slice(service.length + 1).replaceAll("/", ".")];
  return services.length === 1 && !given ? [services[0], ""] : ["", ""];
}

function list(services, present) {
  element("services").hidden = services.length < 2;
  element("services").replaceChildren(...services.map((each) =>
    make("a", {href: `/#${each}`, "aria-current": each === present && "page"}, each)));
}

function listen(service, part, gui) {
  const isGroup = gui.attributes.kind === "group";
  // A group that has a value is a mount: its value is which names it has.
  const groups = new Set(all(gui).filter((each) => each.attributes.kind === "group").map((each) => each.attributes.name));
  const names = isGroup ? "all=1" : `names=(${part})`;
  stream = new EventSource(at(`/${service}/${part && isGroup ? `${part}.` : ""}properties?values=1&every=0.05&${names}`));
  const first = new Map();
  const told = (event) => Object.fromEntries(event.lastEventId.split(";").map((each) => each.split("=")));
  stream.onopen = () => say("live");
  stream.onmessage = (event) => {
    const {name, quality} = told(event);
    if (!/(^|\.)properties$/.test(name) && !groups.has(name)) panel.show(name, event.data, {quality});
    else if ((first.get(name) ?? event.data) !== event.data) open();  // names have come or gone
    else first.set(name, event.data);
  };
  stream.addEventListener("base64-text", (event) => {
    const raw = Uint8Array.from(atob(event.data), (each) => each.charCodeAt(0));
    panel.show(told(event).name, new TextDecoder().decode(raw), {...told(event), isRaw: true});
  });
  stream.addEventListener("bytes", (event) => panel.show(told(event).name, `${event.data} bytes`, {...told(event), isRaw: true}));
  stream.addEventListener("refused", (event) => {
    const code = /^(?:no-service|timeout)\b/.exec(event.data)?.[0];
    panel.show(told(event).name, code ? "" : event.data, {code, why: code && event.data, quality: "bad", isRaw: true});
  });
  stream.addEventListener("end", (event) => panel.show(told(event).name, "", {code: event.data, isRaw: true}));
  stream.onerror = () => lost("the connection is lost");
}

// Whoever is not known is asked once for a password, not again each second.
function lost(why, isStranger) {
  stream?.close();
  const hint = isStranger ? " Reload the page to be asked again." : "";
  say(`Not there: ${why}. What is shown was so at ${new Date().toLocaleTimeString()}.${hint}`, true);
  clearTimeout(again);
  if (!isStranger) again = setTimeout(open, LATER_MS);
}

window.addEventListener("hashchange", open);
open();
setTimeout(look, LOOK_MS);
