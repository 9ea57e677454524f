// The drawing of a board, in which wires and terminals are clicked, and the list of its wires, for keyboards.
const DRAWN = new Set(["svg", "title", "g", "rect", "line", "polyline", "circle", "text"]);

// Returns the drawing without whatever could run as a script: it has names out of a file.
function drawingOf(text) {
  const svg = document.importNode(new DOMParser().parseFromString(text, "image/svg+xml").documentElement, true);
  for (const each of [svg, ...svg.querySelectorAll("*")]) {
    if (!DRAWN.has(each.localName)) each.remove();
    for (const { name } of [...each.attributes]) if (/^on/i.test(name)) each.removeAttribute(name);
  }
  return svg;
}

// Returns how far a point is from a polyline, in the drawing's pixels.
function distance({ x, y }, { points }) {
  return Math.min(...[...points].slice(1).map((end, number) => {
    const start = points[number];
    const [dx, dy] = [end.x - start.x, end.y - start.y];
    const along = Math.max(0, Math.min(1, ((x - start.x) * dx + (y - start.y) * dy) / (dx * dx + dy * dy || 1)));
    return Math.hypot(x - start.x - along * dx, y - start.y - along * dy);
  }));
}

export default {
  template: `<div class="clicked-board wide">
    <div ref="board" class="board" tabindex="0" role="region" aria-label="Wires and terminals to choose" 
      :title="near" @click="click" @pointermove="over"></div>
    <details><summary>Wires ({{ wires.length }})</summary><ul class="board-wires">
      <li v-for="wire in wires" :key="wire.name"><button type="button" :aria-pressed="isChosen.has(wire.name)"
        @click="$emit('clicked', [wire.name])">{{ wire.words }}</button></li></ul></details></div>`,
  props: { address: String, chosen: Array },
  data: () => ({ wires: [], near: "" }),
  computed: {
    isChosen() {
      return new Set(this.chosen);
    },
  },
  watch: { isChosen: "mark" },
  async mounted() {
    const answer = await fetch(this.address);
    if (!answer.ok || !this.$refs.board) return;
    const svg = drawingOf(await answer.text());
    this.drawn = [...svg.querySelectorAll("[data-wire]")];
    for (const wire of this.drawn) {  // a wire is thinner than what a finger hits
      const area = wire.querySelector("polyline").cloneNode();
      area.classList.add("area");
      wire.prepend(area);
      const title = wire.querySelector("title");  // of the wire on top, which need not be the nearest
      title.remove();
      this.wires.push({ name: wire.dataset.wire, words: title.textContent });
    }
    this.$refs.board?.replaceChildren(svg);
    this.mark();
  },
  methods: {
    mark() {
      for (const wire of this.drawn || []) wire.classList.toggle("chosen", this.isChosen.has(wire.dataset.wire));
    },
    // Returns the terminal that an event is on, if any, and the wire that is the nearest to it.
    at({ clientX, clientY }) {
      const under = document.elementsFromPoint(clientX, clientY);
      const areas = under.filter((each) => each.matches(".area"));
      const point = areas.length && new DOMPoint(clientX, clientY).matrixTransform(areas[0].getScreenCTM().inverse());
      areas.sort((one, other) => distance(point, one) - distance(point, other));
      return { terminal: under.find((each) => each.dataset.terminal)?.dataset.terminal, wire: areas[0]?.parentNode };
    },
    over(event) {
      const { terminal, wire } = this.at(event);
      const near = terminal ? undefined : wire;
      if (near === this.lit) return;
      this.lit?.classList.remove("near");
      near?.classList.add("near");
      this.lit = near;
      this.near = near ? this.wires[this.drawn.indexOf(near)].words : "";
    },
    click(event) {
      const { terminal, wire } = this.at(event);
      const wires = terminal ? this.drawn.filter(({ dataset: { a, b } }) => a === terminal || b === terminal) : wire ? [wire] : [];
      if (wires.length) this.$emit("clicked", wires.map((each) => each.dataset.wire));
    },
  },
};
