// Where the parts of a chart are drawn: each container by itself, the inner ones first, as their sizes count in the outer one.
// By hand, if the chart says where (`at`); else layered by ELK, in its worker; a large container in rows.
import "/console/vendor/elk-api.js";

const MOST_LAYERED = 30; // states of a container; ELK needs the square of it in time
const MOST_FAILURES = 12; // states from which on failures do not count in the layout; long arrows make it wide
const GAP = { x: 56, y: 48 };
export const PADDING = 18; // of a container
export const HEADER = 26; // room for the title of a container
const START = { width: 14, height: 14 };
const OPTIONS = {
  "elk.algorithm": "layered", "elk.direction": "DOWN", "elk.edgeRouting": "ORTHOGONAL", "elk.padding": "[top=0,left=0,bottom=0,right=0]",
  "elk.spacing.nodeNode": "40", "elk.layered.spacing.nodeNodeBetweenLayers": "38", "elk.layered.spacing.edgeNodeBetweenLayers": "14",
  "elk.spacing.edgeNode": "18", "elk.spacing.edgeEdge": "12", "elk.layered.considerModelOrder.strategy": "PREFER_NODES",
  "elk.layered.nodePlacement.strategy": "BRANDES_KOEPF", "elk.layered.nodePlacement.bk.fixedAlignment": "BALANCED",
  "elk.layered.cycleBreaking.strategy": "MODEL_ORDER", "elk.spacing.componentComponent": "40", "elk.aspectRatio": "1.2",
};
const elk = new window.ELK({ workerUrl: "/console/vendor/elk-worker.min.js", algorithms: ["layered"] });

// Returns the upper left corner, the size and, of arrows, the bends and the middle of the label of everything: { boxes: id -> box, routes: id -> points with `labels`, scopes: path -> scope }.
export async function layOut(graph) {
  const children = new Map();
  for (const node of graph.nodes) {
    if (!children.has(node.parent)) children.set(node.parent, []);
    children.get(node.parent).push(node);
  }
  const arrows = new Map();
  const parents = new Map(graph.nodes.map((node) => [node.id, node.parent]));
  for (const edge of graph.edges) {
    const parent = parents.get(edge.source);
    if (!arrows.has(parent)) arrows.set(parent, []);
    arrows.get(parent).push(edge);
  }
  const found = { boxes: new Map(), routes: new Map(), scopes: new Map() };
  await scope(null, 0, 0);
  return found;

  async function scope(parent) {
    const nodes = children.get(parent) || [];
    const inner = new Map();
    for (const node of nodes.filter((one) => children.has(one.id))) inner.set(node.id, await scope(node.id));
    for (const [id, size] of inner) {
      const node = nodes.find((one) => one.id === id);
      node.width = Math.max(size.width + 2 * PADDING, node.width);
      node.height = size.height + 2 * PADDING + HEADER;
    }
    const edges = arrows.get(parent) || [];
    const states = nodes.filter((node) => node.kind !== "outcome" && node.kind !== "start");
    const isPlaced = nodes.some((node) => node.at);
    const place = isPlaced ? byHand : states.length > MOST_LAYERED ? inRows : layered;
    const result = await place(nodes, edges, states);
    for (const [id, box] of result.boxes) found.boxes.set(id, box);
    for (const [id, points] of result.routes) found.routes.set(id, points);
    found.scopes.set(parent, { isPlaced, shift: result.shift || { x: 0, y: 0 } });
    for (const id of inner.keys()) {
      const { x, y } = found.boxes.get(id);
      move(id, x + PADDING, y + PADDING + HEADER);
    }
    return result;
  }

  function move(parent, x, y) { // what is in a container, to where it stands
    for (const node of children.get(parent) || []) {
      const box = found.boxes.get(node.id);
      box.x += x;
      box.y += y;
      if (children.has(node.id)) move(node.id, x, y);
    }
    for (const edge of arrows.get(parent) || []) {
      const points = found.routes.get(edge.id);
      for (const point of points ? [...points, ...points.labels] : []) {
        point.x += x;
        point.y += y;
      }
    }
    const own = found.scopes.get(parent);
    if (own) own.shift = { x: own.shift.x - x, y: own.shift.y - y };
  }
}

async function layered(nodes, edges, states) {
  const last = states.at(-1)?.id;
  const outcomes = new Set(nodes.filter((node) => node.kind === "outcome").map((node) => node.id));
  const counts = (edge) => edge.source !== edge.target
    && (states.length <= MOST_FAILURES || !edge.failure || !outcomes.has(edge.target) || edge.source === last);
  const laid = await elk.layout({
    id: "scope", layoutOptions: OPTIONS,
    children: nodes.map(({ id, width, height }) => ({ id, width, height })),
    edges: edges.filter(counts).map((edge) => ({
      id: edge.id, sources: [edge.source], targets: [edge.target],
      layoutOptions: { "elk.layered.priority.straightness": edge.failure ? "1" : "10", "elk.layered.priority.direction": edge.failure ? "1" : "10" },
      labels: edge.label ? [{ text: edge.label, width: edge.width, height: edge.height }] : [],
    })),
  });
  const boxes = new Map(laid.children.map(({ id, x, y, width, height }) => [id, { x, y, width, height }]));
  const routes = new Map();
  for (const edge of laid.edges) {
    const section = edge.sections?.[0];
    if (!section) continue;
    const points = [section.startPoint, ...(section.bendPoints || []), section.endPoint].map(({ x, y }) => ({ x, y }));
    points.labels = (edge.labels || []).map(({ x, y, width, height }) => ({ x: x + width / 2, y: y + height / 2 }));
    routes.set(edge.id, points);
  }
  return sized(boxes, routes);
}

function inRows(nodes, edges, states) { // to and fro, each state after the one that leads to it
  const next = new Map();
  for (const edge of edges) {
    if (!next.has(edge.source)) next.set(edge.source, []);
    if (edge.failure) next.get(edge.source).push(edge.target);
    else next.get(edge.source).unshift(edge.target);
  }
  const unseen = new Map(states.map((node) => [node.id, node]));
  const order = [];
  const start = nodes.find((node) => node.kind === "start");
  const waiting = start ? [...(next.get(start.id) || [])] : [];
  for (;;) {
    const id = waiting.pop() ?? unseen.keys().next().value;
    if (id === undefined) break;
    const node = unseen.get(id);
    if (!node) continue;
    unseen.delete(id);
    order.push(node);
    waiting.push(...(next.get(id) || []).filter((one) => unseen.has(one)).reverse());
  }
  const width = Math.max(...order.map((node) => node.width)) + GAP.x;
  const height = order.reduce((sum, node) => sum + node.height, 0) / order.length + GAP.y;
  const count = Math.max(1, Math.round(Math.sqrt((order.length * height * 1.3) / width)));
  const boxes = new Map();
  if (start) boxes.set(start.id, { x: 0, y: 13, ...START });
  let y = 0;
  for (let first = 0; first < order.length; first += count) {
    const row = order.slice(first, first + count);
    const isBack = (first / count) % 2 === 1;
    row.forEach((node, place) => boxes.set(node.id, {
      x: GAP.x + (isBack ? count - 1 - place : place) * width, y, width: node.width, height: node.height,
    }));
    y += Math.max(...row.map((node) => node.height)) + GAP.y;
  }
  let x = GAP.x;
  for (const node of nodes.filter((one) => one.kind === "outcome")) {
    boxes.set(node.id, { x, y, width: node.width, height: node.height });
    x += node.width + GAP.x;
  }
  return sized(boxes, new Map());
}

function byHand(nodes) {
  const placed = nodes.filter((node) => node.at);
  const shift = { x: Math.min(...placed.map((node) => node.at[0])), y: Math.min(...placed.map((node) => node.at[1])) };
  const start = nodes.find((node) => node.kind === "start");
  if (start) shift.x -= GAP.x;
  const boxes = new Map();
  for (const { id, at, width, height } of placed) boxes.set(id, { x: at[0] - shift.x, y: at[1] - shift.y, width, height });
  const below = Math.max(...[...boxes.values()].map((box) => box.y + box.height)) + GAP.y;
  let x = start ? GAP.x : 0;
  for (const { id, width, height, kind } of nodes.filter((node) => !node.at)) { // what came after it was placed
    if (kind === "start") continue;
    boxes.set(id, { x, y: below, width, height });
    x += width + GAP.x;
  }
  if (start) {
    const first = boxes.get(start.target);
    boxes.set(start.id, first ? { x: first.x - GAP.x / 2 - 7, y: first.y + first.height / 2 - 7, ...START } : { x: 0, y: 0, ...START });
  }
  return { ...sized(boxes, new Map()), shift };
}

function sized(boxes, routes) {
  const all = [...boxes.values()];
  const right = Math.max(60, ...all.map((box) => box.x + box.width));
  const bottom = Math.max(20, ...all.map((box) => box.y + box.height));
  return { boxes, routes, width: right, height: bottom };
}
