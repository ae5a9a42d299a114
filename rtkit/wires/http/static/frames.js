// Components that services bring along, as HTML. They are strangers: each runs in a sandboxed frame
// of no origin and without a network, and is heard as far as it asks for what lies below its property.
//
// A component sends {id, method: "GET" | "SET", name, value}: `name` is empty for its property itself, or
// leads below it. It gets {id, value} or {id, error}, and {name, value} whenever something changes.

import {make, words} from "./widgets.js";

const NAME = /^$|^(?:[\w+~-]|%[0-9A-Fa-f]{2})+(?:\.(?:[\w+~-]|%[0-9A-Fa-f]{2})+)*$/;
const RESERVED = /(?:^|\.)(?:properties|parameters|gui|listen|meta|history)(?:\.|$)/;
const MOST_A_SECOND = 50;
const LONGEST = 1 << 16;

export class Frame extends HTMLElement {
  begin(gui, source, address) {
    this.name = gui.attributes.name ?? "";
    this.dataset.of = this.name;
    this.source = source;
    this.spent = [];
    const what = this.name || words.service;
    this.opener = make("button", {type: "button", "aria-expanded": "false"}, words.component(what));
    this.append(this.opener);
    this.opener.addEventListener("click", () => this.toggle(what, address));
    this.hear = (event) => { if (this.frame && event.source === this.frame.contentWindow) this.answer(event.data); };
  }

  // Nothing of it runs before somebody wants it to. An address may be one that is to be asked for.
  async toggle(what, address) {
    this.opener.setAttribute("aria-expanded", String(!this.frame));
    if (this.frame) {
      this.frame.remove();
      this.frame = null;
      window.removeEventListener("message", this.hear);
      return;
    }
    const frame = this.frame = make("iframe", {sandbox: "allow-scripts", title: words.component(what), referrerpolicy: "no-referrer"});
    const src = typeof address === "function" ? await address().catch((error) => { this.fail(error); }) : address;
    if (this.frame !== frame || !src) return;  // it was shut meanwhile, or is not to be had
    frame.src = src;
    window.addEventListener("message", this.hear);
    this.append(frame);
  }

  fail(error) {
    this.frame = null;
    this.opener.setAttribute("aria-expanded", "false");
    this.opener.after(make("span", {class: "problem", role: "alert"}, error.message));
  }

  disconnectedCallback() {
    window.removeEventListener("message", this.hear);
  }

  async answer(asked) {
    const id = typeof asked?.id === "number" ? asked.id : 0;
    try {
      this.tell({id, value: await this.carry(asked ?? {})});
    } catch (error) {
      this.tell({id, error: error.message});
    }
  }

  async carry({method, name = "", value = ""}) {
    const now = performance.now();
    this.spent = this.spent.filter((each) => now - each < 1000);
    if (this.spent.push(now) > MOST_A_SECOND) throw new Error("busy too many requests");
    if (typeof name !== "string" || !NAME.test(name) || RESERVED.test(name)) throw new Error("denied only what lies below");
    const target = [this.name, name].filter(Boolean).join(".");
    if (!target) throw new Error("bad-value expected a name");
    if (method === "GET") return this.source.get(target);
    if (method !== "SET") throw new Error("denied GET and SET only");
    if (typeof value !== "string" || value.length > LONGEST) throw new Error("bad-value expected a short text");
    return this.source.set(target, value);
  }

  pass(name, value) {
    const below = this.name ? `${this.name}.` : "";
    if (name === this.name || name.startsWith(below)) this.tell({name: name.slice(below.length), value});
  }

  tell(message) {
    this.frame?.contentWindow?.postMessage(message, "*");  // of no origin, so none can be named
  }
}
customElements.define("rt-frame", Frame);
