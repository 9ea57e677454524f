// The cell in three dimensions, by the three.js of NiceGUI. It paints when something has changed, not all the time.
import { OrbitControls, STLLoader, THREE } from "nicegui-scene";

const PICKED_M = 0.006; // radius within which a click hits a wire [m]
const THINNEST_M = 0.0012; // radius with which a wire is drawn at least [m]
const LOOK_FROM = [1.6, -1.15, 1.0], LOOK_AT = [0.38, 0.0, 0.22]; // [m], world frame

function place(object, at) {
  object.position.set(at[0], at[1], at[2]);
  object.quaternion.set(at[3], at[4], at[5], at[6]);
  return object;
}

function tube(points, radius) {
  const curve = new THREE.CatmullRomCurve3(points.map((point) => new THREE.Vector3(...point)));
  return new THREE.TubeGeometry(curve, Math.max(2, points.length * 2), radius, 6, false);
}

export default {
  template: `<div class="cell-view" role="img" aria-label="The cell"><canvas ref="canvas"></canvas></div>`,
  mounted() {
    try {
      this.renderer = new THREE.WebGLRenderer({ canvas: this.$refs.canvas, antialias: true, alpha: true });
    } catch {
      this.$emit("unavailable");
      return;
    }
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(38, 1, 0.02, 20);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(...LOOK_FROM);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8090a0, 2.2));
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position.set(1, -1, 2);
    this.scene.add(sun);
    const table = new THREE.Mesh(new THREE.PlaneGeometry(1.6, 1.7), new THREE.MeshStandardMaterial({ color: "#c9ced4" }));
    table.position.set(0.4, 0, -0.002);
    this.scene.add(table);
    this.robots = new THREE.Group();
    this.boxes = new THREE.Group();
    this.scene.add(this.robots, this.boxes);
    this.wires = new Map();
    this.moving = new Map();
    this.controls = new OrbitControls(this.camera, this.$refs.canvas);
    this.controls.target.set(...LOOK_AT);
    this.controls.addEventListener("change", () => this.paint());
    this.controls.update();
    this.$refs.canvas.addEventListener("pointerdown", (event) => (this.pressed = [event.clientX, event.clientY]));
    this.$refs.canvas.addEventListener("pointerup", (event) => this.pick(event));
    this.sizes = new ResizeObserver(() => this.resize());
    this.sizes.observe(this.$el);
    this.resize();
    this.$el.screenPointOf = (name) => this.screenPointOf(name); // for tests
    this.$emit("ready");
  },
  unmounted() {
    this.sizes?.disconnect();
    this.controls?.dispose();
    this.renderer?.dispose();
  },
  methods: {
    change(changes) {
      if (!this.renderer) return;
      if (changes.robots) this.build(changes.robots);
      for (const [name, value] of Object.entries(changes.joints ?? {})) this.turn(name, value);
      if (changes.boxes) this.setBoxes(changes.boxes);
      for (const name of changes.gone) this.dropWire(name);
      for (const [name, wire] of Object.entries(changes.wires)) this.setWire(name, wire);
      this.$el.dataset.changes = Number(this.$el.dataset.changes ?? 0) + 1;
      this.$el.dataset.wires = [...this.wires.keys()].sort().join(" ");
      this.paint(true);
    },
    build(robots) {
      this.robots.clear();
      this.moving.clear();
      for (const robot of robots) {
        const links = new Map();
        for (const [name, shapes] of Object.entries(robot.shapes)) {
          const link = new THREE.Group();
          for (const shape of shapes) link.add(this.shape(shape));
          links.set(name, link);
        }
        for (const joint of robot.joints) {
          const fixed = place(new THREE.Group(), joint.at), moved = new THREE.Group();
          fixed.add(moved);
          moved.add(links.get(joint.child));
          links.get(joint.parent).add(fixed);
          this.moving.set(robot.prefix + joint.name, { moved, kind: joint.kind, axis: new THREE.Vector3(...joint.axis) });
        }
        this.robots.add(place(links.get(robot.root), robot.at));
      }
    },
    shape(shape) {
      const material = new THREE.MeshStandardMaterial({ color: shape.colour, roughness: 0.6 });
      const mesh = new THREE.Mesh(new THREE.BoxGeometry(1, 1, 1), material);
      mesh.scale.set(...shape.size);
      if (shape.mesh) {
        mesh.visible = false;
        mesh.userData.isFile = true;
        new STLLoader().load(shape.mesh, (geometry) => {
          geometry.computeVertexNormals();
          mesh.geometry = geometry;
          mesh.visible = true;
          this.$el.dataset.meshes = this.count(this.robots, (part) => part.userData.isFile && part.visible);
          this.paint();
        });
      }
      return place(mesh, shape.at);
    },
    count(group, matches) {
      let found = 0;
      group.traverse((part) => (found += matches(part) ? 1 : 0));
      return found;
    },
    turn(name, value) {
      const joint = this.moving.get(name);
      if (!joint) return;
      if (joint.kind === "prismatic") joint.moved.position.copy(joint.axis).multiplyScalar(value);
      else if (joint.kind === "revolute") joint.moved.quaternion.setFromAxisAngle(joint.axis, value);
    },
    setBoxes(boxes) {
      this.boxes.clear();
      for (const box of boxes) this.boxes.add(this.shape({ ...box, mesh: "" }));
    },
    setWire(name, { points, diameter, colour }) {
      this.dropWire(name);
      if (points.length < 2) return;
      const shown = new THREE.Mesh(
        tube(points, Math.max(diameter / 2, THINNEST_M)),
        new THREE.MeshStandardMaterial({ color: colour, roughness: 0.5 }),
      );
      const target = new THREE.Mesh(tube(points, PICKED_M), new THREE.MeshBasicMaterial({ visible: false }));
      target.userData.wire = name;
      this.scene.add(shown, target);
      this.wires.set(name, [shown, target]);
    },
    dropWire(name) {
      for (const mesh of this.wires.get(name) ?? []) {
        this.scene.remove(mesh);
        mesh.geometry.dispose();
        mesh.material.dispose();
      }
      this.wires.delete(name);
    },
    pick(event) {
      if (!this.pressed || Math.hypot(event.clientX - this.pressed[0], event.clientY - this.pressed[1]) > 4) return;
      const box = this.$refs.canvas.getBoundingClientRect();
      const at = new THREE.Vector2(
        (2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
      const ray = new THREE.Raycaster();
      ray.setFromCamera(at, this.camera);
      const [hit] = ray.intersectObjects([...this.wires.values()].map(([, target]) => target));
      if (hit) this.$emit("pick", hit.object.userData.wire);
    },
    screenPointOf(name) { // of the middle of a wire [pixels of the page]
      const points = this.wires.get(name)[1].geometry.parameters.path.points;
      const point = points[Math.floor(points.length / 2)].clone().project(this.camera);
      const box = this.$refs.canvas.getBoundingClientRect();
      return [box.left + ((point.x + 1) / 2) * box.width, box.top + ((1 - point.y) / 2) * box.height];
    },
    resize() {
      const { clientWidth: width, clientHeight: height } = this.$el;
      if (!width || !height) return;
      this.renderer.setPixelRatio(window.devicePixelRatio);
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      this.paint();
    },
    paint(reports = false) {
      this.reports = this.reports || reports;
      if (this.isDue) return;
      this.isDue = true;
      requestAnimationFrame(() => {
        this.isDue = false;
        this.renderer.render(this.scene, this.camera);
        if (this.reports) this.$emit("painted");
        this.reports = false;
      });
    },
  },
};
