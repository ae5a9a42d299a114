// A small stand-in for `rtkit web`, for work on the page: node's http only. `node mock/server.mjs [PORT] [COMPONENTS]`.
// It serves the built page with the real policy headers, a scripted picture that changes each second, and does what it is asked.
import { createReadStream, existsSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';

import { components, connectors, managers, many, processes } from './system.mjs';
import { layoutOf } from './layout.mjs';

const PORT = Number(process.argv[2] ?? 8137);
const STATIC = join(import.meta.dirname, '../../rtkit/web/static');
const POLICY =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; worker-src 'self'; font-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml', '.json': 'application/json' };

const system = { managers, processes, components: [...components], connectors: [...connectors] };
if (process.argv[3]) many(system, Number(process.argv[3]));
const pages = new Set();
const kept = [];
let revision = 1;
const now = () => Date.now() / 1000;
const find = (id) => system.components.find((one) => one.id === id);
const send = (page, event, data) => page.write(`event: ${event}\ndata: ${JSON.stringify(data)}\n\n`);

function tell(change, events = []) {
  revision += 1;
  const gone = { managers: [], processes: [], components: [], connectors: [], ...change.gone };
  const whole = { revision, time: now(), managers: [], processes: [], components: [], connectors: [], ...change, gone, events };
  kept.push(...events);
  for (const page of pages) send(page, 'change', whole);
}
const happened = (path, event, detail, kind = 'RTC_STATUS') => ({ time: now(), kind, path, subject: path, event, detail });

function become(one, state, look = state.toLowerCase(), word = state, remark = '') {
  Object.assign(one, { state, look, word, remark, since: now() });
  one.contexts.forEach((context) => (context.state = state));
  tell({ components: [one] }, [happened(one.id, state.toUpperCase(), remark)]);
}

// Each action: the line of the shell, the sentence, the inverse, and what it does to the picture.
const acts = {
  activate: (a) => ({ command: `rtact ${a.component}`, text: `Activate ${a.component}`, undo: { ...a, do: 'deactivate' }, run: () => become(find(a.component), 'Active') }),
  deactivate: (a) => ({ command: `rtdeact ${a.component}`, text: `Deactivate ${a.component}`, undo: { ...a, do: 'activate' }, run: () => become(find(a.component), 'Inactive') }),
  reset: (a) => ({ command: `rtreset ${a.component}`, text: `Reset ${a.component}`, why: 'A reset has no inverse.', run: () => become(find(a.component), 'Inactive') }),
  delete: (a) => ({ command: `rtdel ${a.component}`, text: `End ${a.component}`, why: `${find(a.component)?.name} would end`, run: () => end(a.component) }),
  connect: (a) => {
    const id = a.id ?? `wire-${a.source}-${a.target}`;
    return { command: `rtcon ${Object.entries(a.properties ?? {}).map(([k, v]) => `-p ${k}=${v} `).join('')}${a.source} ${a.target}`, text: `Connect ${a.source} with ${a.target}`, undo: { do: 'disconnect', connector: id }, run: () => connect(a, id) };
  },
  disconnect: (a) => {
    const wire = system.connectors.find((one) => one.id === a.connector);
    const [source, target] = [wire.source, wire.target].map((end) => `${end.component}:${end.port}`);
    return { command: `rtdis ${source} ${target}`, text: `Disconnect ${source} from ${target}`, undo: { do: 'connect', source, target, id: wire.id, name: wire.name, properties: wire.properties }, run: () => drop([wire.id]) };
  },
  configure: (a) => {
    const set = find(a.component).sets[a.set];
    const before = Object.fromEntries(Object.keys(a.values).map((key) => [key, set[key]]));
    if (a.expect && Object.entries(a.expect).some(([key, value]) => set[key] !== value)) throw new Error(`Another value than expected is in ${a.component}.`);
    return { command: `rtconf ${a.component} set ${Object.entries(a.values).map(([k, v]) => `${k} ${v}`).join(' ')}`, text: `Configure ${a.component}`, undo: { ...a, values: before, expect: a.values }, run: () => { Object.assign(set, a.values); tell({ components: [find(a.component)] }); } };
  },
  activate_set: (a) => ({ command: `rtconf ${a.component} act ${a.set}`, text: `Activate set ${a.set}`, undo: { ...a, set: find(a.component).active_set }, run: () => { find(a.component).active_set = a.set; tell({ components: [find(a.component)] }); } }),
  rate: (a) => {
    const context = find(a.component).contexts.find((one) => one.id === a.context);
    return { command: `rtrate ${a.component} ${a.rate_hz}`, text: `Set the rate to ${a.rate_hz} Hz`, undo: { ...a, rate_hz: context.rate_hz }, run: () => { context.rate_hz = a.rate_hz; tell({ components: [find(a.component)] }); } };
  },
};

function connect(a, id) {
  const end = (path) => ({ component: path.slice(0, path.lastIndexOf(':')), port: path.slice(path.lastIndexOf(':') + 1) });
  const wire = { id, name: a.name ?? 'wire', source: end(a.source), target: end(a.target), properties: a.properties ?? {}, trouble: '' };
  system.connectors.push(wire);
  tell({ connectors: [wire] }, [happened(a.source, 'connected', a.target, 'TREE_EVENT')]);
}
function drop(ids) {
  system.connectors = system.connectors.filter((one) => !ids.includes(one.id));
  tell({ gone: { connectors: ids } }, [happened('/localhost', 'disconnected', ids.join(' '), 'TREE_EVENT')]);
}
function end(id) {
  const wires = system.connectors.filter((one) => one.source.component === id || one.target.component === id).map((one) => one.id);
  system.connectors = system.connectors.filter((one) => !wires.includes(one.id));
  system.components = system.components.filter((one) => one.id !== id);
  tell({ gone: { components: [id], connectors: wires } }, [happened(id, 'removed', '', 'TREE_EVENT')]);
}

function perform({ actions, dry_run }) {
  const steps = [], undo = [];
  let why = '';
  for (const action of actions) {
    try {
      const act = acts[action.do](action);
      if (!dry_run) act.run();
      steps.push({ text: act.text, command: act.command, ok: dry_run ? null : true, error: '' });
      if (act.undo) undo.unshift(act.undo);
      else why = act.why;
    } catch (error) {
      steps.push({ text: `${action.do} ${action.component ?? ''}`, command: '', ok: false, error: error.message });
      break;
    }
  }
  return { steps, undo: why ? null : undo, undo_reason: why };
}

function connectable(path) {
  const at = path.lastIndexOf(':');
  const own = find(path.slice(0, at))?.ports.find((port) => port.name === path.slice(at + 1));
  return system.components.flatMap((one) => one.ports.map((port) => {
    const wrong = one.id === path.slice(0, at) ? 'A component is not connected with itself.'
      : own.direction === 'service' ? (port.direction === 'service' ? '' : 'A service port takes a service port only.')
      : port.direction === own.direction || port.direction === 'service' ? 'The direction does not fit.'
      : port.type !== own.type ? `The types differ: ${own.type} and ${port.type}.` : '';
    return { path: `${one.id}:${port.name}`, type: port.type, why: wrong };
  }));
}

async function body(request) {
  const chunks = [];
  for await (const chunk of request) chunks.push(chunk);
  return JSON.parse(Buffer.concat(chunks).toString() || '{}');
}
const json = (response, value, status = 200) => response.writeHead(status, { 'Content-Type': 'application/json' }).end(JSON.stringify(value));

createServer(async (request, response) => {
  const url = new URL(request.url, 'http://mock');
  response.setHeader('Content-Security-Policy', POLICY);
  if (!url.pathname.startsWith('/api/')) {
    const file = join(STATIC, normalize(url.pathname === '/' ? '/index.html' : url.pathname));
    if (!existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { 'Content-Type': TYPES[extname(file)] ?? 'text/plain' });
    return createReadStream(file).pipe(response);
  }
  if (request.headers.authorization !== 'Bearer mock') return json(response, { error: { kind: 'denied', text: 'The token is wrong.' } }, 401);
  if (url.pathname === '/api/stream') {
    response.writeHead(200, { 'Content-Type': 'text/event-stream', 'Cache-Control': 'no-store' });
    pages.add(response);
    request.on('close', () => pages.delete(response));
    return send(response, 'picture', { revision, host: 'butler', version: '1.4.0', read_only: process.env.READ_ONLY === '1', jobs: [], ...system });
  }
  if (url.pathname === '/api/layout') return json(response, { revision, ...layoutOf(system, (await body(request)).folded) });
  if (url.pathname === '/api/do') return json(response, perform(await body(request)));
  if (url.pathname === '/api/connectable') return json(response, { ports: connectable(url.searchParams.get('port')) });
  if (url.pathname === '/api/events') return json(response, { events: kept });
  return json(response, { error: { kind: 'missing', text: 'There is no such call.' } }, 404);
}).listen(PORT, '127.0.0.1', () => console.log(`http://127.0.0.1:${PORT}/#token=mock`));

let tick = 0;
setInterval(() => {
  tick += 1;
  for (const page of pages) page.write(': alive\n\n');
  const hz = (wire, index) => (wire.trouble ? 0 : [10, 30, 30, 100, 2, 1000][index % 6] + Math.sin(tick + index) / 4);
  const rates = { connectors: {}, components: {} };
  system.connectors.forEach((wire, index) => (rates.connectors[wire.id] = { hz: hz(wire, index), written: tick * 10 }));
  system.components.forEach((one) => (rates.components[one.id] = { hz: one.contexts[0]?.rate_hz ?? null, load: 0.1 }));
  for (const page of pages) send(page, 'rates', rates);
  if (process.env.STILL) return;
  const speaker = find('/localhost/Speaker0.rtc');
  if (tick % 4 === 0 && speaker) become(speaker, speaker.state === 'Active' ? 'Inactive' : 'Active');
}, 1000);
