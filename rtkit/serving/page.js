// The page of the HTTP door: one property, live. Values are shown as text and never run.
"use strict";

const element = (id) => document.getElementById(id);
let stream = null;

async function names() {
  const asked = await (await fetch("/ps", {headers: {Accept: "application/json"}})).json();
  for (const service of asked.value) {
    const told = await (await fetch(`/ps/${service}`, {headers: {Accept: "application/json"}})).json();
    for (const name of told.value) {
      const option = document.createElement("option");
      option.value = `${service}/${name}`;
      element("names").append(option);
    }
  }
  element("state").textContent = "ready";
}

function show(text, id) {
  element("value").textContent = text;
  element("told").textContent = id;
  element("state").textContent = "live";
}

function listen() {
  if (stream) stream.close();
  const target = element("target").value;
  location.hash = target;
  if (!target) return;
  stream = new EventSource(`/ps/${target}`);
  stream.onmessage = (event) => show(event.data, event.lastEventId);
  stream.addEventListener("base64", (event) => show(`base64: ${event.data}`, event.lastEventId));
  stream.addEventListener("base64-text", (event) => show(atob(event.data), event.lastEventId));
  stream.addEventListener("end", (event) => {
    stream.close();
    show("", event.lastEventId);
    element("state").textContent = event.data;
  });
  stream.onerror = () => { element("state").textContent = "not there"; };
}

element("target").addEventListener("change", listen);
element("set").addEventListener("submit", async (event) => {
  event.preventDefault();
  const reply = await fetch(`/ps/${element("target").value}`, {method: "PUT", body: element("wanted").value});
  if (!reply.ok) element("state").textContent = await reply.text();
});
element("target").value = decodeURIComponent(location.hash.slice(1));
names().catch((error) => { element("state").textContent = String(error); });
listen();
