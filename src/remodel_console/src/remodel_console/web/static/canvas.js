// The drawing of a chart. `draw` gets an SVG that the server made; all else only changes classes and the view box.
const READABLE = 0.8; // [screen pixels per unit of the drawing] below this, text is too small to read
const LARGEST = 3.0;
const REST_MS = 400; // between two moves of the drawing after what is active

export default {
  template: `
    <div class="canvas-frame" tabindex="0" role="group" :aria-label="label" @keydown="key">
      <div ref="stage" class="canvas-stage" @wheel.prevent="wheel" @pointerdown="down" @pointermove="move"
           @pointerup="up" @pointercancel="up"></div>
      <div ref="map" class="canvas-map" @pointerdown="jump"></div>
      <div class="canvas-tools">
        <button type="button" title="Zoom in (+)" aria-label="Zoom in" @click="zoom(1.25)">+</button>
        <button type="button" title="Zoom out (−)" aria-label="Zoom out" @click="zoom(0.8)">−</button>
        <button type="button" title="Show all (0)" aria-label="Show all" @click="fit">⤢</button>
      </div>
    </div>`,
  props: { label: String },
  mounted() {
    this.pointers = new Map();
    this.active = "";
    this.passed = new Set();
    this.asked = false;
    this.restsUntil = 0;
    this.resized = new ResizeObserver(() => this.resize());
    this.resized.observe(this.$refs.stage);
  },
  beforeUnmount() {
    this.resized.disconnect();
    clearTimeout(this.later);
  },
  methods: {
    draw(svg, keepsView) {
      const stage = this.$refs.stage;
      const before = this.view;
      stage.innerHTML = svg;
      this.svg = stage.querySelector("svg");
      if (!this.svg) {
        this.$refs.map.replaceChildren();
        this.groups = undefined;
        return;
      }
      const [, , width, height] = this.svg.getAttribute("viewBox").split(" ").map(Number);
      this.size = { width, height };
      this.svg.removeAttribute("width");
      this.svg.removeAttribute("height");
      this.svg.setAttribute("preserveAspectRatio", "xMidYMid meet");
      this.centre();
      const map = this.svg.cloneNode(true);
      this.$refs.map.replaceChildren(map);
      this.frame = document.createElementNS("http://www.w3.org/2000/svg", "rect");
      this.frame.setAttribute("class", "canvas-view");
      map.append(this.frame);
      this.groups = new Map();
      for (const group of this.$el.querySelectorAll("g[data-path]")) {
        const path = group.dataset.path;
        if (!this.groups.has(path)) this.groups.set(path, []);
        this.groups.get(path).push(group);
      }
      if (keepsView && before) {
        this.view = before;
        this.show();
      } else {
        this.open();
      }
      this.marked = new Map();
      this.select(this.selected || "");
      this.lightUp(this.active, [...this.passed], true, this.asked);
      if (this.active) this.reveal(this.active);
    },
    centre() { // Graphviz only estimates the width of texts
      for (const node of this.svg.querySelectorAll("g.node")) {
        const shape = node.querySelector("path, polygon, ellipse");
        const { x, width } = shape.getBBox();
        for (const text of node.querySelectorAll("text")) {
          text.setAttribute("text-anchor", "middle");
          text.setAttribute("x", x + width / 2);
        }
      }
    },
    light(active, passed, isNewRun, asked) {
      this.lightUp(active, passed, isNewRun, asked);
      requestAnimationFrame(() => setTimeout(() => this.$emit("painted"))); // a hidden page paints nothing
    },
    lightUp(active, passed, isNewRun, asked) { // `passed` holds what is new, unless it is a new run
      this.passed = new Set(isNewRun ? passed : [...this.passed, ...passed]);
      const hasMoved = active && active !== this.active;
      this.active = active;
      this.asked = asked;
      if (!this.groups) return;
      const parts = active ? active.split("/") : [];
      const around = parts.slice(0, -1).map((_, end) => parts.slice(0, end + 1).join("/"));
      this.mark("active", active ? [active] : []);
      this.mark("around", around);
      this.mark("asked", active && asked ? [active] : []);
      if (isNewRun) this.mark("passed", passed);
      else for (const path of passed) this.add("passed", path);
      this.$el.dataset.active = active;
      if (hasMoved) this.reveal(active);
    },
    select(path) {
      this.selected = path;
      if (!this.groups) return;
      this.mark("selected", path ? [path] : []);
      if (path) this.reveal(path);
    },
    mark(name, paths) {
      for (const group of this.marked.get(name) || []) group.classList.remove(name);
      this.marked.set(name, []);
      for (const path of paths) this.add(name, path);
    },
    add(name, path) {
      for (const group of this.groups.get(path) || []) {
        group.classList.add(name);
        this.marked.get(name).push(group);
      }
    },
    scale() {
      return this.$refs.stage.clientWidth / this.view.width;
    },
    resize() {
      if (!this.svg || !this.$refs.stage.clientWidth) return;
      const { clientWidth, clientHeight } = this.$refs.stage;
      if (this.view && this.ratio) this.view.height = (this.view.width * clientHeight) / clientWidth;
      else this.open();
      this.show();
    },
    open() { // whole if that can be read, else the top of it
      const { clientWidth, clientHeight } = this.$refs.stage;
      if (!clientWidth) return;
      const whole = Math.min(clientWidth / this.size.width, clientHeight / this.size.height, 1.25);
      const scale = Math.max(whole, READABLE);
      const width = clientWidth / scale;
      const height = clientHeight / scale;
      const start = this.svg.querySelector("g.node");
      const box = start ? this.boxOf(start) : { x: this.size.width / 2, y: 0, width: 0, height: 0 };
      const within = (middle, part, all) => (part >= all ? (all - part) / 2 : Math.min(Math.max(middle - part / 2, 0), all - part));
      const x = within(box.x + box.width / 2, width, this.size.width);
      const y = within(box.y + box.height / 2, height, this.size.height);
      this.view = { x, y, width, height };
      this.ratio = true;
      this.show();
    },
    fit() {
      if (!this.svg) return;
      const { clientWidth, clientHeight } = this.$refs.stage;
      const scale = Math.min(clientWidth / this.size.width, clientHeight / this.size.height, 1.25);
      const width = clientWidth / scale;
      const height = clientHeight / scale;
      this.view = { x: (this.size.width - width) / 2, y: (this.size.height - height) / 2, width, height };
      this.show();
    },
    show() {
      const { x, y, width, height } = this.view;
      this.svg.setAttribute("viewBox", `${x} ${y} ${width} ${height}`);
      const covers = x <= 0 && y <= 0 && x + width >= this.size.width && y + height >= this.size.height;
      this.$refs.map.style.display = covers ? "none" : "";
      for (const [name, value] of Object.entries(this.view)) this.frame.setAttribute(name, value);
    },
    zoom(factor, at) {
      if (!this.svg) return;
      const now = this.scale();
      const whole = Math.min(this.$refs.stage.clientWidth / this.size.width, this.$refs.stage.clientHeight / this.size.height);
      const next = Math.min(LARGEST, Math.max(Math.min(whole, 1) * 0.8, now * factor));
      const { x, y, width, height } = this.view;
      const to = at || { x: x + width / 2, y: y + height / 2 };
      const ratio = now / next;
      this.view = { x: to.x - (to.x - x) * ratio, y: to.y - (to.y - y) * ratio, width: width * ratio, height: height * ratio };
      this.show();
    },
    point(event) { // of the screen, in units of the drawing
      const box = this.$refs.stage.getBoundingClientRect();
      return { x: this.view.x + (event.clientX - box.x) / this.scale(), y: this.view.y + (event.clientY - box.y) / this.scale() };
    },
    wheel(event) {
      if (this.svg) this.zoom(Math.exp(-event.deltaY / 400), this.point(event));
    },
    down(event) {
      this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      this.travelled = 0;
    },
    move(event) {
      const last = this.pointers.get(event.pointerId);
      if (!last || !this.svg) return;
      const now = { x: event.clientX, y: event.clientY };
      if (this.pointers.size === 2) {
        const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
        const spread = (a) => Math.hypot(a.x - other.x, a.y - other.y) || 1;
        this.zoom(spread(now) / spread(last), this.point({ clientX: other.x, clientY: other.y }));
      } else {
        this.travelled += Math.hypot(now.x - last.x, now.y - last.y);
        if (this.travelled > 4) this.$refs.stage.setPointerCapture(event.pointerId);
        this.view.x -= (now.x - last.x) / this.scale();
        this.view.y -= (now.y - last.y) / this.scale();
        this.show();
      }
      this.pointers.set(event.pointerId, now);
    },
    up(event) {
      const was = this.pointers.delete(event.pointerId);
      if (!was || event.type === "pointercancel" || this.travelled > 4) return;
      const group = event.target.closest("g[data-path]");
      this.$emit("pick", group ? group.dataset.path : "");
    },
    jump(event) {
      const box = this.$refs.map.firstChild.getBoundingClientRect();
      const scale = this.size.width / box.width;
      this.view.x = (event.clientX - box.x) * scale - this.view.width / 2;
      this.view.y = (event.clientY - box.y) * scale - this.view.height / 2;
      this.show();
    },
    key(event) {
      if (!this.svg) return;
      const step = this.view.width / 10;
      const deeds = {
        "+": () => this.zoom(1.25), "=": () => this.zoom(1.25), "-": () => this.zoom(0.8), 0: () => this.fit(),
        ArrowLeft: () => (this.view.x -= step), ArrowRight: () => (this.view.x += step),
        ArrowUp: () => (this.view.y -= step), ArrowDown: () => (this.view.y += step),
      };
      if (!deeds[event.key] || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      deeds[event.key]();
      this.show();
    },
    boxOf(group) { // in units of the view box; Graphviz moves its whole graph
      const box = group.getBBox();
      const graph = this.svg.querySelector("g.graph").transform.baseVal;
      let x = 0, y = 0;
      for (let index = 0; index < graph.numberOfItems; index += 1) {
        x += graph.getItem(index).matrix.e;
        y += graph.getItem(index).matrix.f;
      }
      return { x: box.x + x, y: box.y + y, width: box.width, height: box.height };
    },
    reveal(path) { // not so often that an operator cannot follow; the last one always
      clearTimeout(this.later);
      const now = performance.now();
      if (now < this.restsUntil) {
        this.later = setTimeout(() => this.reveal(path), this.restsUntil - now);
        return;
      }
      this.restsUntil = now + REST_MS;
      const group = (this.groups.get(path) || []).find((one) => this.svg.contains(one));
      if (!group) return;
      const box = this.boxOf(group);
      const { x, y, width, height } = this.view;
      const nearest = (start, length, from, size) => { // the least move that shows it, with some room around it
        const room = Math.min(30, Math.max(0, (length - size) / 2));
        if (from < start + room) return from - room;
        return Math.max(start, from + size + room - length);
      };
      this.view.x = nearest(x, width, box.x, box.width);
      this.view.y = nearest(y, height, box.y, box.height);
      this.show();
    },
  },
};
