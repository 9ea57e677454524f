// The drawing of a chart, by cytoscape: `draw` gets the parts of it, see core/drawing.py; layout.js places them.
import cytoscape from "/console/vendor/cytoscape.esm.min.mjs";
import { layOut, HEADER, PADDING } from "/console/layout.js";
import { svgOf } from "/console/picture.js";

const READABLE = 0.6; // [screen pixels per unit of the drawing] below this, text is too small to read
const LARGEST = 3.0;
const MOST_VALUES = 8; // that are shown beside a state
const PAINT_MS = 200; // between two paintings of the whole drawing while states change; the frame around the active one moves at once
const REST_MS = 400; // between two moves of the drawing after what is active
const LINGER_MS = 300; // for which the outcomes of a state stay after the pointer has left it
const FONT = "12px Helvetica, Arial, sans-serif";
const LINE = 15; // height of a line of text
const GRID = 10; // on which states are placed by hand
const NODE_TYPE = "application/x-remodel-node"; // of what is dragged from the library
const AT_ONCE = 300; // nodes; of a larger drawing, what is in view is painted first
const SLICE = 500; // nodes that are then added between two frames
const MARGIN = 24; // around a drawing that is seen whole
const BADGE = (colour, text) => `data:image/svg+xml;utf8,${encodeURIComponent(
  `<svg xmlns="http://www.w3.org/2000/svg" width="18" height="18"><circle cx="9" cy="9" r="8" fill="${colour}"/>`
  + `<text x="9" y="13" font-family="Helvetica,Arial" font-size="12" font-weight="bold" fill="#fff" text-anchor="middle">${text}</text></svg>`)}`;

const pen = document.createElement("canvas").getContext("2d");
pen.font = FONT;
const widths = new Map();
const widthOf = (text) => {
  if (!widths.has(text)) widths.set(text, Math.max(...text.split("\n").map((line) => pen.measureText(line).width)));
  return widths.get(text);
};
cytoscape.warnings(false); // of arrows that cannot be drawn before all has its place
const pathsOf = (elements) => elements.map((one) => one.data("path"));

export default {
  template: `
    <div class="canvas-frame" tabindex="0" role="group" :aria-label="label" @keydown="key">
      <div ref="stage" class="canvas-stage" @dragover="over" @drop="drop"></div>
      <i ref="lit" class="canvas-lit" aria-hidden="true"></i>
      <svg class="canvas-rubber" aria-hidden="true"><line ref="rubber"/></svg>
      <div ref="handles" class="canvas-handles" @pointerenter="linger" @pointerleave="leave"></div>
      <dl ref="values" class="canvas-values" aria-hidden="true"></dl>
      <div ref="map" class="canvas-map" aria-hidden="true" @pointerdown="jump"><img ref="small" alt=""><i ref="window"></i></div>
      <div class="canvas-tools">
        <button v-if="editable" type="button" title="Data flow" aria-label="Data flow" aria-pressed="false" ref="flow" @click="showFlow">⇢</button>
        <button type="button" title="Download the picture as PNG" aria-label="Download the picture as PNG" class="words" @click="picture">PNG</button>
        <button type="button" title="Download the picture as SVG" aria-label="Download the picture as SVG" class="words" @click="vectors">SVG</button>
        <button type="button" title="Zoom in (+)" aria-label="Zoom in" @click="zoom(1.25)">+</button>
        <button type="button" title="Zoom out (−)" aria-label="Zoom out" @click="zoom(0.8)">−</button>
        <button type="button" title="Show all (0)" aria-label="Show all" @click="fit">⤢</button>
      </div>
      <ul ref="outline" class="canvas-outline" aria-label="States and transitions"></ul>
    </div>`,
  props: { label: String, editable: Boolean },
  mounted() {
    this.active = "";
    this.passed = new Set();
    this.asked = false;
    this.wanted = [];
    this.restsUntil = 0;
    this.paintsAt = 0;
    this.turn = 0;
    this.picks = 0; // by a person
    this.kept = new Map(); // marks by name, for the next drawing too
    this.dragged = new Set(); // containers in which something was moved
    this.cy = cytoscape({
      container: this.$refs.stage, style: this.style(), minZoom: 0.04, maxZoom: LARGEST, autoungrabify: !this.editable,
      boxSelectionEnabled: this.editable, selectionType: "single", textureOnViewport: false,
    });
    this.$el.drawing = this; // for tests, which look up where something is drawn
    this.watch();
    this.resized = new ResizeObserver(() => this.resize());
    this.resized.observe(this.$refs.stage);
    this.themed = new MutationObserver(() => this.cy.style(this.style()));
    this.themed.observe(document.body, { attributes: true, attributeFilter: ["class"] });
  },
  beforeUnmount() {
    this.resized.disconnect();
    this.themed.disconnect();
    clearTimeout(this.later);
    clearTimeout(this.leaving);
    clearTimeout(this.painting);
    this.cy.destroy();
  },
  methods: {
    watch() {
      const cy = this.cy;
      cy.on("tap", (event) => {
        if (event.target === cy) cy.$(":selected").unselect();
        this.picks += 1; // at once: an answer to the last pick may come before what is selected now is read
        setTimeout(() => this.picked(event.target === cy ? "" : event.target.data("pick")));
      });
      cy.on("boxend", () => {
        this.picks += 1;
        setTimeout(() => this.picked());
      });
      cy.on("pan zoom", () => {
        this.placeValues();
        this.placeLit();
      });
      if (!this.editable) return;
      cy.on("mouseover", "node", (event) => this.showHandles(event.target));
      cy.on("mouseout", "node", () => this.leave());
      cy.on("pan zoom", () => this.placeHandles());
      cy.on("drag", "node", (event) => {
        event.target.union(event.target.descendants()).connectedEdges(".routed").removeClass("routed");
        this.placeHandles();
      });
      cy.on("dragfreeon", "node", (event) => {
        this.dragged.add(event.target.data("parent"));
        this.box = undefined;
        clearTimeout(this.freed);
        this.freed = setTimeout(() => this.moved()); // once, if several were moved
      });
    },
    picked(around) { // what is selected now; a start or an end means what is around it
      const chosen = pathsOf(this.cy.$("node:selected").filter((one) => one.data("selectable")));
      this.wanted = chosen;
      this.$emit("pick", { paths: chosen.length ? chosen : around ? [around] : [], number: this.picks });
    },

    // Drawing

    async draw(graph, keepsView) {
      const began = performance.now();
      const turn = (this.turn += 1);
      for (const node of graph.nodes) this.measure(node);
      for (const edge of graph.edges) {
        edge.width = edge.label ? widthOf(edge.label) + 8 : 0;
        edge.height = edge.label ? edge.label.split("\n").length * LINE : 0;
      }
      const found = await layOut(graph);
      if (turn !== this.turn) return; // another drawing has come meanwhile
      const cy = this.cy;
      const keeps = keepsView && cy.elements().nonempty() && !this.seesAll(); // what was seen whole stays so
      const handled = cy.getElementById(this.handled || "").data("path");
      this.scopes = found.scopes;
      this.name = graph.name;
      this.box = around([...found.boxes.values()], [...found.routes.values()].flat());
      const start = graph.nodes.find((node) => node.kind === "start" && node.parent === null);
      this.start = start && found.boxes.get(start.id);
      this.hideHandles();
      cy.elements().remove();
      this.byPath = new Map();
      this.items = new Map();
      this.marked = new Map(); // what is drawn with each mark
      this.worded = new Map(); // the same, in the words
      this.paintsAt = 0;
      this.hasAll = false;
      if (graph.nodes.length && !keeps) this.open();
      found.containers = new Set(graph.nodes.map((node) => node.parent));
      const [first, ...others] = this.slices(graph, found.boxes);
      this.build(first, found);
      this.lightUp(this.active, [...this.passed], true, this.asked);
      painted().then(() => {
        if (turn === this.turn) this.$el.dataset.drawnMs = (performance.now() - began).toFixed(0);
      });
      for (const slice of others) {
        await painted();
        if (turn !== this.turn) return;
        this.build(slice, found);
      }
      this.hasAll = true;
      this.outline(graph);
      for (const [name, paths] of this.kept) this.mark(name, paths);
      this.placeValues();
      this.lightUp(this.active, [...this.passed], true, this.asked);
      if (this.active) this.reveal(this.active); // it may have become active before this was drawn
      this.select(this.wanted, false);
      if (handled && this.byPath.has(handled)) this.showHandles(this.byPath.get(handled));
      this.drawMap();
      this.$el.dataset.drawn = String(graph.nodes.length);
      await painted();
      if (turn === this.turn) this.$el.dataset.completeMs = (performance.now() - began).toFixed(0);
    },
    slices(graph, boxes) { // parts of a graph in the order in which they are added: what is in view first
      if (graph.nodes.length <= AT_ONCE) return [graph];
      const turns = new Map();
      const view = this.cy.extent();
      const parents = new Map(graph.nodes.map((node) => [node.id, node.parent]));
      const needed = (id) => {
        for (; id !== null && turns.get(id) !== 0; id = parents.get(id)) turns.set(id, 0);
      };
      const outermost = new Map(); // what a container's size depends on
      for (const { id, parent } of graph.nodes) {
        const { x, y, width, height } = boxes.get(id);
        if (x <= view.x2 && x + width >= view.x1 && y <= view.y2 && y + height >= view.y1) needed(id);
        if (parent === null) continue;
        const most = outermost.get(parent) || [];
        [-x, -y, x + width, y + height].forEach((far, side) => {
          if (!most[side] || far > most[side].far) most[side] = { id, far };
        });
        outermost.set(parent, most);
      }
      for (const most of outermost.values()) for (const { id } of most) needed(id);
      let count = 0;
      for (const { id } of graph.nodes) {
        if (turns.has(id)) continue;
        for (let one = id; one !== null && !turns.has(one); one = parents.get(one)) turns.set(one, 1 + Math.floor(count / SLICE));
        count += 1;
      }
      const slices = Array.from({ length: 2 + Math.floor(count / SLICE) }, () => ({ nodes: [], edges: [], flows: [] }));
      for (const node of graph.nodes) slices[turns.get(node.id)].nodes.push(node);
      for (const kind of ["edges", "flows"]) {
        for (const edge of graph[kind] || []) slices[Math.max(turns.get(edge.source), turns.get(edge.target))][kind].push(edge);
      }
      return slices;
    },
    build(slice, found) {
      const added = this.cy.add(this.elements(slice, found));
      this.route(slice, found);
      for (const node of added.nodes()) this.byPath.set(node.data("path"), node);
    },
    measure(node) {
      const text = node.kind === "outcome" || node.kind === "missing" ? node.name : `${node.name}\n${node.type}`;
      node.label = node.kind === "start" ? "" : node.container ? `${node.name}${node.type ? `  (${node.type})` : ""}` : text.trim();
      const lines = node.label.split("\n").length;
      node.width = node.kind === "start" ? 14 : Math.ceil(widthOf(node.label)) + 28;
      node.height = node.kind === "start" ? 14 : lines * LINE + 14;
    },
    elements(graph, { boxes, routes, containers }) {
      const middle = (id) => {
        const { x, y, width, height } = boxes.get(id);
        return { x: x + width / 2, y: y + height / 2 };
      };
      const nodes = graph.nodes.map((node) => {
        const { x, y, width, height } = boxes.get(node.id);
        const isState = !["start", "outcome", "missing"].includes(node.kind);
        return {
          group: "nodes",
          data: { ...node, parent: node.parent ?? undefined, width, height, selectable: isState, at: undefined },
          position: { x: x + width / 2, y: y + height / 2 },
          selectable: isState, grabbable: node.kind !== "start" && node.kind !== "missing",
          classes: [node.kind, node.container ? "container" : "", node.failure ? "failure" : "",
            node.errors ? "error" : node.warnings ? "warning" : ""].filter(Boolean).join(" "),
        };
      });
      const edges = graph.edges.map((edge) => {
        const isFree = !containers.has(edge.source) && !containers.has(edge.target); // else see `route`
        const bends = isFree && routeData(routes.get(edge.id), middle(edge.source), middle(edge.target));
        return {
          group: "edges", selectable: false, data: { ...edge, ...bends, width: undefined, height: undefined },
          classes: [edge.failure ? "failure" : "", edge.autonomy ? `autonomy-${edge.autonomy}` : "", bends ? "routed" : ""].filter(Boolean).join(" "),
        };
      });
      const flows = (graph.flows || []).map((flow) => ({
        group: "edges", selectable: false, data: { ...flow, id: `f:${flow.source}>${flow.target}`, pick: "" }, classes: this.flowing ? "flow" : "flow hidden",
      }));
      return [...nodes, ...edges, ...flows];
    },
    route(graph, { routes, containers }) { // the arrows of containers as the layout has led them; their sizes are known only once they are drawn
      const edges = graph.edges.filter(({ id, source, target }) => routes.has(id) && (containers.has(source) || containers.has(target)));
      if (!edges.length) return;
      const middles = new Map(this.cy.nodes(":parent").map((node) => {
        const { x1, y1, x2, y2 } = node.boundingBox({ includeLabels: false, includeOverlays: false });
        return [node.id(), { x: (x1 + x2) / 2, y: (y1 + y2) / 2 }];
      }));
      const middle = (node) => middles.get(node.id()) || node.position();
      this.cy.batch(() => {
        for (const edge of edges) {
          const one = this.cy.getElementById(edge.id);
          const bends = routeData(routes.get(edge.id), middle(one.source()), middle(one.target()));
          if (bends) one.data(bends).addClass("routed");
        }
      });
    },
    outline(graph) { // the drawing in words, for who cannot see it
      const item = document.createElement("li");
      this.items = new Map();
      this.$refs.outline.replaceChildren(...graph.nodes.filter((node) => node.kind !== "start").map((node) => {
        const line = item.cloneNode();
        line.className = node.container ? "cluster" : node.kind === "outcome" ? "end" : "node";
        line.dataset.path = node.path;
        line.dataset.kind = node.kind;
        line.dataset.problems = String((node.errors || 0) + (node.warnings || 0));
        line.textContent = `${node.path}${node.type ? `: ${node.type}` : ""}`;
        if (node.kind !== "outcome") this.items.set(node.path, line);
        return line;
      }), ...graph.edges.filter((edge) => edge.label).map((edge) => {
        const line = item.cloneNode();
        line.className = "edge";
        Object.assign(line.dataset, { source: edge.from, target: edge.to, autonomy: edge.autonomy || "" });
        line.textContent = `${edge.from}: ${edge.label.replaceAll("\n", ", ")} leads to ${edge.to}`;
        return line;
      }), ...(graph.flows || []).map((flow) => {
        const line = item.cloneNode();
        line.className = "flow";
        line.textContent = `${flow.from}: ${flow.label} is read by ${flow.to}`;
        return line;
      }));
    },
    style() {
      const of = getComputedStyle(document.body);
      const colour = (name) => of.getPropertyValue(`--${name}`).trim();
      const autonomy = { low: colour("autonomy-low"), high: colour("autonomy-high"), full: colour("autonomy-full") };
      const edge = (line, more) => ({ "line-color": line, "target-arrow-color": line, color: line, ...more });
      const box = (fill, line, width = 1.4) => ({ "background-color": fill, "border-color": line, "border-width": width });
      return [
        { selector: "node", style: {
          shape: "round-rectangle", width: "data(width)", height: "data(height)", label: "data(label)", color: colour("ink"), "font-family": "Helvetica, Arial, sans-serif",
          "font-size": 12, "line-height": 1.25, "text-wrap": "wrap", "text-valign": "center", "min-zoomed-font-size": 4, "overlay-opacity": 0,
          ...box(colour("state-fill"), colour("state-line")),
        } },
        { selector: "node.behavior", style: box(colour("behavior-fill"), colour("behavior-line")) },
        { selector: "node.closed", style: { ...box(colour("box-fill"), colour("soft")), "border-style": "double", "border-width": 3 } },
        { selector: "node.missing", style: { ...box(colour("bad-fill"), colour("bad")), "border-style": "dashed" } },
        { selector: "node.outcome", style: { ...box(colour("success-fill"), colour("success-line")), "corner-radius": 18 } },
        { selector: "node.outcome.failure", style: box(colour("failure-fill"), colour("failure")) },
        { selector: "node.start", style: { shape: "ellipse", "background-color": colour("ink"), "border-width": 0 } },
        { selector: "node.container", style: {
          ...box(colour("box-fill"), colour("soft"), 1.2), padding: PADDING, "text-valign": "top", "text-margin-y": -2, "font-weight": "bold",
          "compound-sizing-wrt-labels": "exclude", width: 40, height: 20,
        } },
        { selector: "node.concurrency", style: { "border-style": "dashed" } },
        { selector: "node.priority", style: { "border-style": "double", "border-width": 3 } },
        { selector: "edge", style: {
          width: 1.3, "curve-style": "bezier", "target-arrow-shape": "triangle", "arrow-scale": 0.9, label: "data(label)", "font-size": 11, "line-height": 1.2,
          "text-wrap": "wrap", "font-family": "Helvetica, Arial, sans-serif", "text-background-color": colour("ground"), "text-background-opacity": 0.85,
          "text-background-padding": 1, "min-zoomed-font-size": 5, "overlay-opacity": 0, "control-point-step-size": 36, ...edge(colour("ink")),
        } },
        { selector: "edge.failure", style: edge(colour("failure"), { "line-style": "dashed" }) },
        ...Object.entries(autonomy).map(([level, line]) => ({ selector: `edge.autonomy-${level}`, style: edge(line, { width: 2.4 }) })),
        { selector: "edge.routed", style: {
          "curve-style": "round-segments", "edge-distances": "endpoints", "segment-weights": "data(weights)", "segment-distances": "data(distances)",
          "segment-radii": 8, "source-endpoint": "data(from)", "target-endpoint": "data(to)",
          "text-margin-x": "data(labelX)", "text-margin-y": "data(labelY)",
        } },
        { selector: "edge.flow", style: edge(colour("flow"), { "line-style": "dotted", width: 2, "curve-style": "unbundled-bezier", "control-point-distances": 40, "control-point-weights": 0.5 }) },
        { selector: ".hidden", style: { display: "none" } },
        ...[["error", colour("bad"), "!"], ["warning", colour("warn-line"), "?"]].map(([kind, line, text]) => ({ selector: `node.${kind}`, style: {
          "border-color": line, "border-width": 2, "background-image": BADGE(line, text), "background-width": 18, "background-height": 18, "background-fit": "none",
          "background-position-x": "100%", "background-position-y": "0%", "background-offset-x": 7, "background-offset-y": -7, "background-clip": "none",
          "background-image-containment": "over", "bounds-expansion": 8,
        } })),
        { selector: "node.stopping", style: {
          "background-image": BADGE(colour("bad"), ""), "background-width": 14, "background-height": 14, "background-fit": "none", "background-position-x": "0%",
          "background-position-y": "0%", "background-offset-x": -6, "background-offset-y": -6, "background-clip": "none", "background-image-containment": "over",
          "bounds-expansion": 8,
        } },
        { selector: "node.passed", style: box(colour("passed-fill"), colour("lit")) },
        { selector: "node.around", style: { "border-color": colour("lit"), "border-width": 2 } },
        { selector: "node.active", style: box(colour("lit-fill"), colour("lit"), 3) },
        { selector: "node.asked", style: box(colour("asked-fill"), colour("asked-line"), 3) },
        { selector: "node.target", style: { "border-color": colour("good"), "border-width": 3 } },
        { selector: "node:selected", style: { "border-color": colour("accent"), "border-width": 3 } },
      ];
    },

    // What is active, what is selected

    light(active, passed, isNewRun, asked) {
      this.lightUp(active, passed, isNewRun, asked);
      requestAnimationFrame(() => setTimeout(() => this.$emit("painted"))); // a hidden page paints nothing
    },
    lightUp(active, passed, isNewRun, asked) { // `passed` holds what is new, unless it is a new run
      this.passed = new Set(isNewRun ? passed : [...this.passed, ...passed]);
      const hasMoved = active && active !== this.active;
      this.active = active;
      this.asked = asked;
      if (!this.byPath) return;
      this.$el.dataset.active = active;
      const parts = active ? active.split("/") : [];
      this.markWords("active", active ? [active] : []);
      this.markWords("around", parts.slice(0, -1).map((_, end) => parts.slice(0, end + 1).join("/")));
      this.markWords("asked", active && asked ? [active] : []);
      if (isNewRun) this.markWords("passed", passed);
      else this.addWords("passed", passed);
      this.placeLit();
      this.paintLit();
      if (hasMoved) this.reveal(active);
    },
    placeLit() { // a frame around what is active: to move it costs nothing, while each change of the drawing paints all of it
      const node = this.active && this.byPath?.get(this.active);
      const frame = this.$refs.lit;
      frame.style.display = node && node.nonempty() ? "block" : "none";
      if (frame.style.display === "none") return;
      frame.classList.toggle("asked", this.asked);
      const [{ x, y }, width, height] = [node.renderedPosition(), node.renderedOuterWidth(), node.renderedOuterHeight()];
      Object.assign(frame.style, {
        transform: `translate(${x - width / 2}px, ${y - height / 2}px)`, width: `${width}px`, height: `${height}px`,
        borderWidth: `${Math.max(1.5, 3 * this.cy.zoom())}px`, borderRadius: `${8 * this.cy.zoom()}px`,
      });
    },
    paintLit() { // at once after a rest, else soon
      clearTimeout(this.painting);
      const now = performance.now();
      if (now < this.paintsAt) {
        this.painting = setTimeout(() => this.paintLit(), this.paintsAt - now);
        return;
      }
      this.paintsAt = now + PAINT_MS;
      this.cy.batch(() => {
        for (const name of ["active", "around", "asked", "passed"]) this.paintMark(name, this.worded.get(name) || []);
      });
    },
    select(paths, reveals = true, number = Infinity) { // number: of the pick that it answers; a person may have picked more since
      if (number < this.picks) return;
      this.wanted = paths;
      if (!this.byPath) return;
      const chosen = new Set(paths);
      this.cy.batch(() => {
        for (const node of this.cy.$("node:selected")) if (!chosen.has(node.data("path"))) node.unselect();
        for (const path of paths) this.byPath.get(path)?.select();
      });
      this.mark("selected", paths);
      if (paths.length && reveals) this.reveal(paths[0]);
      const only = paths.length === 1 && this.byPath.get(paths[0]);
      if (only && this.editable) this.showHandles(only);
      else this.hideHandles();
    },
    keepMark(name, paths) {
      this.kept.set(name, paths);
      if (this.hasAll) this.mark(name, paths);
    },
    mark(name, paths) { // in the drawing and in its words
      this.markWords(name, paths);
      this.paintMark(name, paths);
    },
    markWords(name, paths) { // in the words
      for (const path of this.worded.get(name) || []) this.items.get(path)?.classList.remove(name);
      this.worded.set(name, []);
      this.addWords(name, paths);
    },
    addWords(name, paths) {
      const known = paths.filter((path) => this.byPath.has(path));
      for (const path of known) this.items.get(path)?.classList.add(name);
      this.worded.get(name).push(...known);
    },
    paintMark(name, paths) { // in the drawing
      const wanted = new Set(paths.filter((path) => this.byPath.has(path)));
      const marked = this.marked.get(name) || new Set();
      for (const path of marked) if (!wanted.has(path)) this.byPath.get(path)?.removeClass(name);
      for (const path of wanted) if (!marked.has(path)) this.byPath.get(path).addClass(name);
      this.marked.set(name, wanted);
    },

    // The view

    resize() {
      const sawAll = this.isOpen && this.cy.elements().nonempty() && this.seesAll();
      this.cy.resize();
      if (sawAll) this.fit();
      if (this.cy.elements().nonempty() && !this.isOpen) this.open();
      this.drawMap();
    },
    open() { // whole if that can be read, else its beginning
      const cy = this.cy;
      if (!cy.width() || !this.box) return;
      this.isOpen = true;
      const box = this.extent();
      this.fit();
      if (cy.zoom() < READABLE) {
        const { x, y } = this.start || { x: box.x1, y: box.y1 };
        const within = (at, from, to, size) => (to - from < size ? (size - from - to) / 2 : Math.min(MARGIN - from, Math.max(size - MARGIN - to, size / 2 - at)));
        cy.viewport({ zoom: READABLE, pan: {
          x: within(x * READABLE, box.x1 * READABLE, box.x2 * READABLE, cy.width()),
          y: within(y * READABLE, box.y1 * READABLE, box.y2 * READABLE, cy.height()),
        } });
      }
      this.showMap();
    },
    fit() {
      const cy = this.cy;
      const { x1, y1, x2, y2 } = this.extent();
      const zoom = Math.max(cy.minZoom(), Math.min(1.25, (cy.width() - 2 * MARGIN) / (x2 - x1), (cy.height() - 2 * MARGIN) / (y2 - y1)));
      cy.viewport({ zoom, pan: { x: (cy.width() - zoom * (x1 + x2)) / 2, y: (cy.height() - zoom * (y1 + y2)) / 2 } });
      this.showMap();
    },
    zoom(factor) {
      this.cy.zoom({ level: this.cy.zoom() * factor, renderedPosition: { x: this.cy.width() / 2, y: this.cy.height() / 2 } });
    },
    drawMap() {
      if (!this.isOpen || this.cy.elements().empty()) {
        this.$refs.map.style.display = "none";
        return;
      }
      clearTimeout(this.mapping);
      this.mapping = setTimeout(() => {
        this.box = this.cy.elements().boundingBox(); // with labels, as in the picture
        this.$refs.small.src = this.cy.png({ full: true, maxWidth: 260, maxHeight: 260 });
        this.showMap();
      }, REST_MS);
      this.cy.off("pan zoom", this.showMap).on("pan zoom", this.showMap);
    },
    extent() { // of the whole drawing; what was moved may lie outside of it
      if (!this.box) {
        const corners = this.cy.nodes().map((node) => this.boxOf(node));
        this.box = around(corners.map(({ x1, y1, x2, y2 }) => ({ x: x1, y: y1, width: x2 - x1, height: y2 - y1 })), []);
      }
      return this.box;
    },
    seesAll() {
      const box = this.extent();
      const view = this.cy.extent();
      return view.x1 <= box.x1 && view.y1 <= box.y1 && view.x2 >= box.x2 && view.y2 >= box.y2;
    },
    showMap() { // where the view is in the whole; not if all is seen
      const box = this.extent();
      const view = this.cy.extent();
      this.$refs.map.style.display = this.seesAll() ? "none" : "block";
      const share = (at, from, to) => Math.min(100, Math.max(0, (100 * (at - from)) / (to - from)));
      const [left, top] = [share(view.x1, box.x1, box.x2), share(view.y1, box.y1, box.y2)];
      Object.assign(this.$refs.window.style, {
        left: `${left}%`, top: `${top}%`, width: `${share(view.x2, box.x1, box.x2) - left}%`, height: `${share(view.y2, box.y1, box.y2) - top}%`,
      });
    },
    jump(event) {
      const frame = this.$refs.map.getBoundingClientRect();
      const box = this.extent();
      const x = box.x1 + ((event.clientX - frame.x) / frame.width) * (box.x2 - box.x1);
      const y = box.y1 + ((event.clientY - frame.y) / frame.height) * (box.y2 - box.y1);
      this.cy.pan({ x: this.cy.width() / 2 - x * this.cy.zoom(), y: this.cy.height() / 2 - y * this.cy.zoom() });
    },
    key(event) {
      const move = (x, y) => this.cy.panBy({ x, y });
      const deeds = {
        "+": () => this.zoom(1.25), "=": () => this.zoom(1.25), "-": () => this.zoom(0.8), 0: () => this.fit(),
        ArrowLeft: () => move(60, 0), ArrowRight: () => move(-60, 0), ArrowUp: () => move(0, 60), ArrowDown: () => move(0, -60),
      };
      if (!deeds[event.key] || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      deeds[event.key]();
    },
    reveal(path) { // not so often that an operator cannot follow; the last one always
      clearTimeout(this.later);
      const now = performance.now();
      if (now < this.restsUntil) {
        this.later = setTimeout(() => this.reveal(path), this.restsUntil - now);
        return;
      }
      this.restsUntil = now + REST_MS;
      const node = this.byPath.get(path);
      if (!node) return;
      const box = node.renderedBoundingBox();
      const nearest = (from, to, size) => { // the least move that shows it, with some room around it
        const room = Math.min(40, Math.max(0, (size - (to - from)) / 2));
        return from < room ? room - from : to > size - room ? Math.max(size - room - to, room - from) : 0;
      };
      this.cy.panBy({ x: nearest(box.x1, box.x2, this.cy.width()), y: nearest(box.y1, box.y2, this.cy.height()) });
    },
    where(path) { // on the page
      const node = this.byPath?.get(path);
      if (!node) return null;
      const box = this.$refs.stage.getBoundingClientRect();
      const own = node.renderedBoundingBox({ includeLabels: false, includeOverlays: false });
      const top = node.isParent() ? own.y1 + 6 : (own.y1 + own.y2) / 2;
      return { x: box.x + (node.isParent() ? own.x1 + 8 : (own.x1 + own.x2) / 2), y: box.y + top };
    },
    showValues(path, values) { // beside a state
      const list = this.$refs.values;
      this.valued = values.length ? path : "";
      list.replaceChildren(...values.slice(0, MOST_VALUES).flatMap(([key, value]) => {
        const [term, text] = [document.createElement("dt"), document.createElement("dd")];
        term.textContent = key;
        text.textContent = value;
        text.title = value;
        return [term, text];
      }));
      list.dataset.path = this.valued;
      this.placeValues();
    },
    placeValues() {
      const node = this.valued && this.byPath?.get(this.valued);
      const isShown = Boolean(node && node.nonempty());
      this.$refs.values.style.display = isShown ? "grid" : "none";
      if (!isShown) return;
      const box = node.renderedBoundingBox({ includeLabels: false, includeOverlays: false });
      Object.assign(this.$refs.values.style, { left: `${box.x2 + 6}px`, top: `${box.y1}px` });
    },
    scale() {
      return this.cy.zoom();
    },
    showFlow() {
      this.flowing = !this.flowing;
      this.$refs.flow.setAttribute("aria-pressed", String(this.flowing));
      this.cy.edges(".flow").toggleClass("hidden", !this.flowing);
    },
    ground() {
      return getComputedStyle(document.body).getPropertyValue("--ground").trim();
    },
    async picture() {
      this.save(await this.cy.png({ full: true, scale: 2, bg: this.ground(), maxWidth: 8000, maxHeight: 8000, output: "blob-promise" }), "png");
    },
    vectors() {
      this.save(new Blob([svgOf(this.cy, this.ground())], { type: "image/svg+xml" }), "svg");
    },
    save(blob, kind) {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(blob);
      link.download = `${this.name || "chart"}.${kind}`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    },

    // Editing: outcomes to drag, states to move, states from the library

    showHandles(node) {
      this.linger();
      const events = node.data("events") || [];
      if (this.pulled || this.handled === node.id()) return;
      this.handled = node.id();
      this.$refs.handles.replaceChildren(...events.map(({ event, target }) => {
        const handle = document.createElement("button");
        handle.type = "button";
        handle.textContent = event;
        handle.className = target ? "handle" : "handle open";
        handle.title = target ? `'${event}' leads to '${target}'; drag it to lead it elsewhere` : `Drag '${event}' to where it leads`;
        handle.setAttribute("aria-label", `Outcome ${event} of ${node.data("name")}`);
        handle.onpointerdown = (down) => this.pull(down, node, event, handle);
        return handle;
      }));
      this.placeHandles();
    },
    placeHandles() {
      const node = this.handled && this.cy.getElementById(this.handled);
      const isShown = Boolean(node && node.nonempty() && this.$refs.handles.childElementCount);
      this.$refs.handles.style.display = isShown ? "block" : "none";
      if (!isShown) return;
      const box = node.renderedBoundingBox({ includeLabels: false, includeOverlays: false });
      Object.assign(this.$refs.handles.style, { left: `${(box.x1 + box.x2) / 2}px`, top: `${box.y2}px` });
    },
    hideHandles() {
      this.handled = undefined;
      this.$refs.handles.replaceChildren();
      this.$refs.handles.style.display = "none";
    },
    linger() {
      clearTimeout(this.leaving);
    },
    leave() { // the outcomes of the selected state stay
      clearTimeout(this.leaving);
      this.leaving = setTimeout(() => {
        if (this.pulled) return;
        const selected = this.cy.$("node:selected");
        this.hideHandles();
        if (selected.length === 1) this.showHandles(selected[0]);
      }, LINGER_MS);
    },
    pull(down, node, event, handle) { // an outcome to where it leads
      down.preventDefault();
      handle.setPointerCapture(down.pointerId);
      this.pulled = true;
      const frame = this.$refs.stage.getBoundingClientRect();
      const line = this.$refs.rubber;
      const [x1, y1] = [down.clientX - frame.x, down.clientY - frame.y];
      let target;
      handle.onpointermove = (move) => {
        const [x2, y2] = [move.clientX - frame.x, move.clientY - frame.y];
        for (const [name, value] of Object.entries({ x1, y1, x2, y2 })) line.setAttribute(name, value);
        line.style.display = "block";
        const found = this.targetAt(x2, y2, node);
        if (found?.id() !== target?.id()) {
          target?.removeClass("target");
          found?.addClass("target");
          target = found;
        }
      };
      const end = () => {
        handle.onpointermove = handle.onpointerup = handle.onpointercancel = null;
        line.style.display = "none";
        target?.removeClass("target");
        this.pulled = false;
      };
      handle.onpointercancel = end;
      handle.onpointerup = () => {
        end();
        if (target) this.$emit("connect", { path: node.data("path"), event, target: target.data("name") });
        this.leave();
      };
    },
    at(x, y) { // the innermost node at a point of the stage
      const { x: left, y: top } = this.cy.pan();
      const [mx, my] = [(x - left) / this.cy.zoom(), (y - top) / this.cy.zoom()];
      let found;
      for (const node of this.cy.nodes()) {
        const box = this.boxOf(node);
        const isIn = mx >= box.x1 && mx <= box.x2 && my >= box.y1 && my <= box.y2;
        if (isIn && (!found || (box.x2 - box.x1) * (box.y2 - box.y1) < found.area)) found = { node, area: (box.x2 - box.x1) * (box.y2 - box.y1) };
      }
      return { node: found?.node, x: mx, y: my };
    },
    targetAt(x, y, source) { // a state or an outcome beside the source
      let { node } = this.at(x, y);
      const parent = source.data("parent");
      while (node && node.nonempty() && node.data("parent") !== parent) node = node.parent();
      return node && node.nonempty() && !["start", "missing"].includes(node.data("kind")) ? node : undefined;
    },
    boxOf(node) { // with the title of a container
      if (!node.isParent()) {
        const { x, y } = node.position();
        const [w, h] = [node.data("width") / 2, node.data("height") / 2];
        return { x1: x - w, y1: y - h, x2: x + w, y2: y + h };
      }
      const { x1, y1, x2, y2 } = node.boundingBox({ includeLabels: false, includeOverlays: false });
      return { x1, y1: y1 - HEADER, x2, y2 };
    },
    moved() { // where all stands in each container in which something was moved
      for (const parent of this.dragged) this.emitPlaces(parent);
      this.dragged.clear();
    },
    emitPlaces(parent) {
      const nodes = this.cy.nodes().filter((node) => node.data("parent") === parent && !["start", "missing"].includes(node.data("kind")));
      const boxes = nodes.map((node) => [node, this.boxOf(node)]);
      const left = Math.min(...boxes.map(([, box]) => box.x1));
      const top = Math.min(...boxes.map(([, box]) => box.y1));
      const places = { states: {}, outcomes: {} };
      for (const [node, box] of boxes) {
        const kind = node.data("kind") === "outcome" ? places.outcomes : places.states;
        kind[node.data("name")] = [snap(box.x1 - left), snap(box.y1 - top)];
      }
      this.$emit("moved", { scope: parent ? this.cy.getElementById(parent).data("path") : "", ...places });
    },
    over(event) {
      if (!this.editable || !event.dataTransfer.types.includes(NODE_TYPE)) return;
      event.preventDefault();
      event.dataTransfer.dropEffect = "copy";
    },
    drop(event) {
      const what = event.dataTransfer.getData(NODE_TYPE);
      if (!what || !this.editable) return;
      event.preventDefault();
      const frame = this.$refs.stage.getBoundingClientRect();
      let { node, x, y } = this.at(event.clientX - frame.x, event.clientY - frame.y);
      while (node && node.nonempty() && !node.data("container")) node = node.parent();
      const parent = node && node.nonempty() ? node : undefined;
      const scope = this.scopes?.get(parent?.id() ?? null);
      const at = scope?.isPlaced ? [snap(x + scope.shift.x - 50), snap(y + scope.shift.y - 20)] : null;
      this.$emit("dropped", { what, scope: parent?.data("path") || "", at });
    },
  },
};

function routeData(points, from, to) { // the bends of an arrow as cytoscape takes them, from the middle of one node to that of another
  const [first, last] = points ? [points[0], points.at(-1)] : [];
  if (!points || (first.x === last.x && first.y === last.y)) return undefined;
  const [dx, dy] = [last.x - first.x, last.y - first.y];
  const length2 = dx * dx + dy * dy;
  const length = Math.sqrt(length2);
  const bends = points.slice(1, -1).map(({ x, y }) => [x - first.x, y - first.y]);
  const [label] = points.labels;
  const halves = points.slice(Math.floor((points.length - 1) / 2), Math.floor(points.length / 2) + 1); // where cytoscape puts a label
  const half = { x: (halves[0].x + halves.at(-1).x) / 2, y: (halves[0].y + halves.at(-1).y) / 2 };
  return {
    from: `${first.x - from.x}px ${first.y - from.y}px`, to: `${last.x - to.x}px ${last.y - to.y}px`,
    weights: bends.map(([x, y]) => (x * dx + y * dy) / length2).join(" ") || "0.5",
    distances: bends.map(([x, y]) => (x * -dy + y * dx) / length).join(" ") || "0",
    labelX: label ? label.x - half.x : 0, labelY: label ? label.y - half.y : 0,
  };
}

const snap = (value) => Math.round(value / GRID) * GRID;

const painted = () => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));

function around(boxes, points) { // the corners of what holds all of them
  let [x1, y1, x2, y2] = [Infinity, Infinity, -Infinity, -Infinity];
  const take = (x, y) => {
    [x1, y1, x2, y2] = [Math.min(x1, x), Math.min(y1, y), Math.max(x2, x), Math.max(y2, y)];
  };
  for (const { x, y, width, height } of boxes) {
    take(x, y);
    take(x + width, y + height);
  }
  for (const { x, y } of points) take(x, y);
  return x1 <= x2 ? { x1, y1, x2, y2 } : { x1: 0, y1: 0, x2: 1, y2: 1 };
}
