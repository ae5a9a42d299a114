// The page of the HTTP door: one property, live. Values are shown as text and never run.
"use strict";

const element = (id) => document.getElementById(id);
// An address with user and password in it is none that may be fetched from; the origin has neither.
const at = (path) => `${location.origin}/ps${path}`;
const JSON_ONLY = {headers: {Accept: "application/json"}};
let stream = null;
let last = null;

async function names() {
  const asked = await (await fetch(at(""), JSON_ONLY)).json();
  for (const service of asked.value) {
    const told = await (await fetch(at(`/${service}`), JSON_ONLY)).json();
    for (const name of told.value) {
      const option = document.createElement("option");
      option.value = `${service}/${name}`;
      element("names").append(option);
    }
  }
  element("state").textContent = "ready";
}

function show(text, id) {
  last = [text, id];
  element("value").textContent = text;
  element("told").textContent = id;
  element("state").textContent = "live";
}

// What is no longer known to be so is not shown; it is again when the service is back.
function hide(why) {
  element("value").textContent = element("told").textContent = "";
  element("state").textContent = why;
}

function listen() {
  if (stream) stream.close();
  const target = element("target").value;
  location.hash = target;
  last = null;
  hide("asking");
  if (!target) return;
  suit(target);
  stream = new EventSource(at(`/${target}`));
  stream.onopen = () => { if (last) show(...last); };
  stream.onmessage = (event) => show(event.data, event.lastEventId);
  stream.addEventListener("base64", (event) => show(`base64: ${event.data}`, event.lastEventId));
  stream.addEventListener("base64-text", (event) => show(atob(event.data), event.lastEventId));
  stream.addEventListener("end", (event) => {
    stream.close();
    hide(event.data);
  });
  stream.onerror = () => hide("not there");
}

// The component with which a value is set, as the property says in .gui; a line of text else.
async function suit(target) {
  const reply = await fetch(at(`/${target.split("?")[0]}.gui`));
  const text = reply.ok ? await reply.text() : "<gui/>";
  if (element("target").value !== target) return;
  const gui = new DOMParser().parseFromString(text, "text/xml").documentElement;
  const kind = gui.getAttribute("kind") || "text";
  const choices = kind === "toggle" ? "true false" : gui.getAttribute("choices");
  const made = document.createElement(choices ? "select" : "input");
  for (const each of (choices || "").replace(/^\(|\)$/g, "").match(/"[^"]*"|\S+/g) || [])
    made.append(new Option(each, each));
  if (kind === "slider") made.type = "range";
  if (kind === "number") made.type = "number";
  made.step = gui.getAttribute("step") || "any";
  for (const limit of ["min", "max"])
    if (gui.hasAttribute(limit)) made[limit] = gui.getAttribute(limit);
  made.id = "wanted";
  made.hidden = kind === "button";
  element("wanted").replaceWith(made);
  element("unit").textContent = gui.getAttribute("unit") === null ? "" : gui.getAttribute("unit");
  element("set").hidden = kind === "label";
  element("set").dataset.kind = kind;
}

element("target").addEventListener("change", listen);
element("set").addEventListener("submit", async (event) => {
  event.preventDefault();
  const wanted = element("wanted");
  const body = wanted.hidden ? "" : wanted.value;
  const reply = await fetch(at(`/${element("target").value}`), {method: "PUT", body});
  if (!reply.ok) element("state").textContent = await reply.text();
});
element("target").value = decodeURIComponent(location.hash.slice(1));
names().catch((error) => { element("state").textContent = String(error); });
listen();
