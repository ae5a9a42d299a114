// A layout good enough for the mock: each frame is a grid of what it holds; wires go by the middle between two boxes.
const GAP = 64, PAD = 28, HEAD = 36;

export function layoutOf(system, folded) {
  const boxes = {};
  const of = (id) => system.components.find((one) => one.id === id);
  const nodes = (kind, id, children) => ({ kind, id, children });
  const leaf = (one) => one.members.length ? nodes('composite', one.id, one.members.map((id) => leaf(of(id)))) : nodes('component', one.id, []);
  const roots = system.managers.map((manager) => nodes('manager', manager.id, system.processes.filter((one) => one.manager === manager.id).flatMap((process) => {
    const inside = system.components.filter((one) => one.process === process.id && !one.composite).map(leaf);
    return process.is_slave ? [nodes('process', process.id, inside)] : inside;
  })));

  function portsOf({ ports }) {
    const rows = { left: 0, right: 0 };
    return Object.fromEntries(ports.map(({ name, direction }) => {
      const side = direction === 'in' ? 'left' : 'right';
      return [name, { side, y: 42 + 20 * rows[side]++ + 10 }];
    }));
  }
  function size(node) {
    if (node.kind === 'component') {
      const { ports } = of(node.id);
      const left = ports.filter((port) => port.direction === 'in').length;
      return { width: 168, height: 42 + 20 * Math.max(left, ports.length - left, 1) + 8 };
    }
    if (folded.includes(node.id) || !node.children.length) return { width: 200, height: 72 };
    const sizes = node.children.map(size);
    const columns = node.kind === 'composite' ? sizes.length : Math.max(1, Math.ceil(Math.sqrt(sizes.length)) );
    let x = PAD, y = HEAD + 12, low = 0, right = 0;
    sizes.forEach((one, index) => {
      if (index && index % columns === 0) [x, y, low] = [PAD, y + low + 44, 0];
      node.children[index].at = [x, y];
      x += one.width + GAP;
      low = Math.max(low, one.height);
      right = Math.max(right, x - GAP);
    });
    return { width: right + PAD, height: y + low + PAD };
  }
  function put(node, x, y, parent) {
    const isFolded = node.kind !== 'component' && (folded.includes(node.id) || !node.children.length);
    boxes[node.id] = { x, y, ...size(node), parent, kind: node.kind, is_folded: isFolded, ports: node.kind === 'manager' || node.kind === 'process' || isFolded ? {} : portsOf(of(node.id)) };
    if (!isFolded) node.children.forEach((child) => put(child, x + child.at[0], y + child.at[1], node.id));
  }
  let y = 0;
  for (const root of roots) {
    put(root, 0, y, null);
    y += boxes[root.id].height + 40;
  }

  const shown = (id) => {
    for (let one = of(id); one; one = of(one.composite)) if (boxes[one.id]) return one.id;
    return [of(id)?.composite, of(id)?.process, of(id)?.manager].find((at) => boxes[at]);
  };
  const end = ({ component, port }) => {
    const id = shown(component), box = boxes[id];
    if (!box) return null;
    const one = of(component), isIn = one.ports.find((each) => each.name === port)?.direction === 'in';
    const row = id === component ? one.ports.filter((each) => (each.direction === 'in') === isIn).findIndex((each) => each.name === port) : 0;
    return { id, isIn, at: [box.x + (isIn ? 0 : box.width), id === component ? box.y + 42 + 20 * row + 10 : box.y + 46] };
  };
  const paths = {};
  system.connectors.forEach((wire, index) => {
    const [from, to] = [end(wire.source), end(wire.target)];
    if (!from || !to || from.id === to.id) return;
    const [[x1, y1], [x2, y2]] = [from.at, to.at], spread = 14 + (index % 5) * 8;
    const out = x1 + spread, into = to.isIn ? x2 - spread : x2 + spread;
    if (to.isIn && x2 - x1 > 40) paths[wire.id] = [[x1, y1], [out, y1], [out, y2], [x2, y2]];
    else {
      const lane = Math.max(boxes[from.id].y + boxes[from.id].height, boxes[to.id].y + boxes[to.id].height) + 10 + (index % 4) * 6;
      paths[wire.id] = [[x1, y1], [out, y1], [out, lane], [into, lane], [into, y2], [x2, y2]];
    }
  });
  return { width: Math.max(...Object.values(boxes).map((box) => box.x + box.width)), height: y, boxes, paths };
}
