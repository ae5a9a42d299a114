#!/usr/bin/env node
// Client of live properties in node, without any package: lists, gets, sets and listens.
// Over TCP it proves that it knows the secret of the user, the file door.secret of rtkit.
"use strict";
const crypto = require("node:crypto");
const fs = require("node:fs");
const net = require("node:net");
const path = require("node:path");

const USAGE = `usage: node client.js ADDRESS list | get NAME | set NAME VALUE | listen NAME [COUNT]
ADDRESS is unix:PATH or tcp:HOST:PORT`;

class Client {
  constructor(socket) {
    this.socket = socket;
    this.data = Buffer.alloc(0);
    this.waiting = []; // requests that have no reply yet, in order
    this.heard = () => {}; // called with each event
    socket.on("data", (piece) => this.take(piece));
    socket.on("close", () => this.waiting.splice(0).forEach(({ fail }) => fail(Error("closed"))));
  }

  static async open(address) {
    const [scheme, ...rest] = address.split(":");
    const where = scheme === "unix" ? { path: rest.join(":") } : { host: rest[0], port: rest[1] };
    const socket = net.connect(where);
    await new Promise((done, fail) => socket.once("connect", done).once("error", fail));
    const client = new Client(socket);
    if (scheme === "tcp") await client.login();
    return client;
  }

  async login() {
    const home = process.env.XDG_STATE_HOME || path.join(process.env.HOME, ".local", "state");
    const folder = process.env.RTKIT_STATE_DIR || path.join(home, "rtkit");
    const secret = fs.readFileSync(path.join(folder, "door.secret"), "utf8").trim();
    const [user, password] = secret.split(":");
    const nonce = (await this.ask("GET door/nonce")).toString();
    const proof = crypto.createHmac("sha256", password).update(nonce).digest("hex");
    await this.ask(`SET door/identity ${user} ${proof}`);
  }

  ask(line) {
    this.socket.write(`${line}\n`);
    return new Promise((done, fail) => this.waiting.push({ done, fail }));
  }

  take(piece) {
    this.data = Buffer.concat([this.data, piece]);
    for (let end; (end = this.data.indexOf("\n")) >= 0; ) {
      let line = this.data.subarray(0, end).toString();
      let payload;
      const block = / \{(\d+)\}$/.exec(line); // so many bytes follow, and a line end
      if (block) {
        const last = end + 1 + Number(block[1]);
        if (this.data.length <= last) return;
        payload = this.data.subarray(end + 1, last);
        line = line.slice(0, block.index);
        end = last;
      }
      this.data = this.data.subarray(end + 1);
      this.tell(line, payload);
    }
  }

  tell(line, payload) {
    const [, kind, rest] = /^(.) ?(.*)$/.exec(line);
    if (kind === "*") {
      const [, name, text] = /^([^; ]*)[^ ]* ?(.*)$/.exec(rest);
      this.heard(name, payload ?? text);
    } else if (kind === "=") this.waiting.shift().done(payload ?? rest);
    else this.waiting.shift().fail(Error(rest));
  }
}

async function main([address, word, ...more]) {
  const [name, given] = more;
  if (!(more.length >= { list: 0, get: 1, set: 2, listen: 1 }[word])) throw Error(USAGE);
  const client = await Client.open(address);
  if (word === "list") console.log(`${await client.ask("GET properties")}`);
  else if (word === "get") console.log(`${await client.ask(`GET ${name}`)}`);
  else if (word === "set") await client.ask(`SET ${name} ${given}`);
  else {
    let left = Number(given ?? Infinity);
    const heard = new Promise((done) => {
      client.heard = (_, value) => left-- > 0 && (console.log(`${value}`), left || done());
    });
    await client.ask(`SET ${name}.listen?queue=100 self`);
    await heard;
  }
  client.socket.end();
}

if (require.main === module) {
  main(process.argv.slice(2)).catch((error) => (console.error(error.message), process.exit(1)));
}
module.exports = Client;
