// The path in space, to be turned by mouse, touch and keys. It is loaded when it is first looked at.

import {
  Box3, Box3Helper, BufferAttribute, BufferGeometry, CanvasTexture, Color, GridHelper, Group, LineBasicMaterial, LineSegments, type Material, MathUtils, Mesh, MeshBasicMaterial,
  type Object3D, PerspectiveCamera, Points, PointsMaterial, Scene, SphereGeometry, Sprite, SpriteMaterial, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { LineMaterial, type LineMaterialParameters } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { colour, onChange } from "../drawing";
import { canvas, select } from "../elements";
import { AXIS_NAMES } from "../axes";
import { madeAt } from "./flat";
import type { Moment, Shown, View } from "./picture";
import type { Segments } from "./segments";

/** What a key turns by, radians. */
const TURN = Math.PI / 24;
/** From where the whole is seen: the front, the right and above. */
const AWAY = new Vector3(0.75, -1.15, 0.9).normalize();
/** Room around it, as a share. */
const ROOM = 0.06;
/** How wide lines of the path are, px. */
const WIDE_PX = 2.25;
/** More lines than this are a pixel wide: dense ones would hide each other, and a computer without a graphics processor would take a second for them. */
const WIDE_MAX = 8_000;
/** The colour of a colour of the style sheet. */
const shade = (name: string): Color => new Color(colour(name));

/** The lines of the path, twice with the same numbers: the first of them that are made, and all. */
class Lines {
  readonly objects: (Object3D & { material: Material })[];
  private readonly geometry: BufferGeometry;
  private made = 0;

  constructor(private readonly count: number, places: Float32Array, colours: Float32Array) {
    const look = (opacity: number): LineMaterialParameters => ({ vertexColors: true, transparent: opacity < 1, opacity });
    if (count > WIDE_MAX) {
      const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(places, 3)).setAttribute("color", new BufferAttribute(colours, 3));
      this.objects = [1, 0.25].map((opacity) => new LineSegments(geometry, new LineBasicMaterial(look(opacity))));
      this.geometry = geometry;
      this.limit((lines) => geometry.setDrawRange(0, 2 * lines));
    } else {
      const geometry = new LineSegmentsGeometry().setPositions(places).setColors(colours);
      this.objects = [1, 0.25].map((opacity) => new LineSegments2(geometry, new LineMaterial({ ...look(opacity), linewidth: WIDE_PX })));
      this.geometry = geometry;
      this.limit((lines) => (geometry.instanceCount = lines));
    }
  }

  /** So many are made. */
  show(made: number): void {
    this.made = made;
    if (this.objects[1]) this.objects[1].visible = made < this.count;
  }

  dispose(): void {
    this.geometry.dispose();
    for (const object of this.objects) {
      object.material.dispose();
      object.removeFromParent();
    }
  }

  private limit(to: (lines: number) => void): void {
    this.objects.forEach((object, index) => {
      const before = object.onBeforeRender;
      object.frustumCulled = false;
      object.onBeforeRender = (...given) => {
        before.apply(object, given);
        to(index === 0 ? this.made : this.count);
      };
    });
  }
}

export class Space implements View {
  private readonly canvas = canvas("space");
  private readonly renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
  private readonly camera = new PerspectiveCamera(40, 1, 0.1, 10_000);
  private readonly controls = new OrbitControls(this.camera, this.canvas);
  private readonly scene = new Scene();
  private lines = new Lines(0, new Float32Array(), new Float32Array());
  private readonly dots = new Points(new BufferGeometry(), new PointsMaterial({ size: 7, sizeAttenuation: false }));
  private readonly tool = new Mesh(new SphereGeometry(1), new MeshBasicMaterial());
  /** What is around the path: a grid below it, the travel, and the axes where the zero is. */
  private around = new Group();
  private isDue = false;
  /** Nobody has turned it or come nearer: it shows the whole. */
  private isWhole = true;
  private shown: Shown | undefined;
  private moment: Moment = { made: Infinity, tool: undefined };

  constructor() {
    this.camera.up.set(0, 0, 1);
    this.scene.add(this.dots, this.tool, this.around);
    this.controls.addEventListener("change", () => this.render());
    this.controls.addEventListener("start", () => (this.isWhole = false));
    select("fit").addEventListener("change", () => {
      this.isWhole = true;
      if (this.shown) this.paint(this.shown);
    });
    this.canvas.addEventListener("keydown", (event) => this.turnBy(event));
    onChange(this.canvas, () => this.shown && this.paint(this.shown));
  }

  show(shown: Shown): void {
    if (shown.motion !== this.shown?.motion) this.isWhole = true;
    this.shown = shown;
    this.paint(shown);
  }

  at(moment: Moment): void {
    this.moment = moment;
    if (!this.shown) return;
    const { motion, segments } = this.shown;
    this.lines.show(moment.made >= motion.end ? segments.count : madeAt(segments, moment.made));
    this.tool.visible = moment.tool !== undefined;
    if (moment.tool) this.tool.position.copy(placed(moment.tool));
    this.render();
  }

  hide(isHidden: boolean): void {
    this.canvas.hidden = isHidden;
  }

  file(): Promise<Blob | null> {
    // What was drawn is there until the page is shown.
    this.draw();
    return new Promise((resolve) => this.canvas.toBlob(resolve));
  }

  /** Goes as near as the whole is seen. */
  private stand(shown: Shown): void {
    const box = whole(shown);
    const tall = Math.tan(MathUtils.degToRad(this.camera.fov / 2)) * (1 - ROOM);
    const right = new Vector3().crossVectors(this.camera.up, AWAY).normalize();
    const top = new Vector3().crossVectors(AWAY, right);
    box.getCenter(this.controls.target);
    const distances = corners(box).map((corner) => {
      corner.sub(this.controls.target);
      return corner.dot(AWAY) + Math.max(Math.abs(corner.dot(right)) / (tall * this.camera.aspect), Math.abs(corner.dot(top)) / tall);
    });
    const distance = Math.max(...distances, 1);
    this.camera.position.copy(this.controls.target).addScaledVector(AWAY, distance);
    [this.camera.near, this.camera.far] = [distance / 1000, distance * 20];
    this.tool.scale.setScalar(distance / 110);
    this.controls.update();
  }

  /** Takes the colours of the present light, and the size of the canvas. */
  private paint(shown: Shown): void {
    const { segments, tone } = shown;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const shades = tone.colours.map(shade);
    const colours = new Float32Array(6 * segments.count);
    for (let end = 0; end < 2 * segments.count; end++) shades[segments.ranks[end >> 1] ?? 0]?.toArray(colours, 3 * end);
    this.lines.dispose();
    this.lines = new Lines(segments.count, segments.places.slice(0, 6 * segments.count), colours);
    this.scene.add(...this.lines.objects);
    this.dots.geometry.setAttribute("position", new BufferAttribute(dotsOf(segments), 3));
    this.dots.material.color = shade("over");
    this.tool.material.color = shade("tool");
    this.surround(shown);
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    if (this.isWhole) this.stand(shown);
    this.camera.updateProjectionMatrix();
    this.at(this.moment);
  }

  private surround(shown: Shown): void {
    this.around.removeFromParent();
    this.around = new Group();
    const { min, max } = whole(shown);
    const wide = Math.max(max.x - min.x, max.y - min.y, 1) * 1.15;
    const grid = new GridHelper(wide, 10, shade("bound"), shade("grid"));
    grid.rotateX(Math.PI / 2);
    grid.position.set((min.x + max.x) / 2, (min.y + max.y) / 2, min.z);
    this.around.add(grid, ...this.axes(placed(shown.workZero ?? [0, 0, 0]), wide / 8));
    if (shown.travel.length) this.around.add(new Box3Helper(new Box3(new Vector3(), placed(shown.travel)), shade("bound")));
    this.scene.add(this.around);
  }

  /** The axes from a zero, with their letters. */
  private axes(zero: Vector3, length: number): (LineSegments | Sprite)[] {
    return [new Vector3(1, 0, 0), new Vector3(0, 1, 0), new Vector3(0, 0, 1)].flatMap((along, axis) => {
      const name = AXIS_NAMES[axis] ?? "";
      const end = zero.clone().addScaledVector(along, length);
      const line = new LineSegments(new BufferGeometry().setFromPoints([zero, end]), new LineBasicMaterial({ color: shade(name.toLowerCase()) }));
      const letter = letterOf(name, colour(name.toLowerCase()));
      letter.position.copy(end.addScaledVector(along, length / 6));
      letter.scale.setScalar(length / 2.5);
      return [line, letter];
    });
  }

  private turnBy(event: KeyboardEvent): void {
    const [round, up, nearer] = { ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], "+": [0, 0, 1], "-": [0, 0, -1] }[event.key] ?? [];
    if (round === undefined || up === undefined || nearer === undefined) return;
    event.preventDefault();
    this.isWhole = false;
    const away = this.camera.position.clone().sub(this.controls.target);
    const side = new Vector3().crossVectors(this.camera.up, away).normalize();
    away.applyAxisAngle(this.camera.up, round * TURN).applyAxisAngle(side, -up * TURN).multiplyScalar(1 - 0.15 * nearer);
    this.camera.position.copy(this.controls.target).add(away);
    this.controls.update();
    this.render();
  }

  /** Draws it with the next picture of the screen, once, however much changes until then. */
  private render(): void {
    this.isDue ||= requestAnimationFrame(() => this.draw()) > 0;
  }

  private draw(): void {
    this.isDue = false;
    this.renderer.render(this.scene, this.camera);
    // Read by the tests, and by nobody else: how far from the middle the whole reaches, and where the picture ends.
    const reach = this.shown ? corners(whole(this.shown)).flatMap((corner) => corner.project(this.camera).toArray().slice(0, 2)) : [];
    this.canvas.dataset["reach"] = Math.max(...reach.map(Math.abs)).toFixed(2);
  }
}

const placed = ([x = 0, y = 0, z = 0]: number[]): Vector3 => new Vector3(x, y, z);

/** What is looked at: the path; as far as the machine can go if that is wanted, or there is none. */
function whole({ segments: { count, low, high }, travel }: Shown): Box3 {
  const box = count ? new Box3(placed(low), placed(high)) : new Box3();
  if (travel.length && (!count || select("fit").value === "travel")) box.union(new Box3(new Vector3(), placed(travel)));
  return box.isEmpty() ? new Box3(new Vector3(), new Vector3(1, 1, 1)) : box;
}

function corners({ min, max }: Box3): Vector3[] {
  return [min.x, max.x].flatMap((x) => [min.y, max.y].flatMap((y) => [min.z, max.z].map((z) => new Vector3(x, y, z))));
}

function letterOf(name: string, fill: string): Sprite {
  const image = document.createElement("canvas");
  image.width = image.height = 64;
  const context = image.getContext("2d");
  if (context) {
    context.font = "bold 48px system-ui, sans-serif";
    [context.textAlign, context.textBaseline, context.fillStyle] = ["center", "middle", fill];
    context.fillText(name, 32, 34);
  }
  return new Sprite(new SpriteMaterial({ map: new CanvasTexture(image), depthTest: false }));
}

/** Where lines have no length: places where the speed jumps. */
function dotsOf({ places, count }: Segments): Float32Array {
  const dots: number[] = [];
  for (let at = 0; at < 6 * count; at += 6) {
    if ([0, 1, 2].every((axis) => places[at + axis] === places[at + axis + 3])) dots.push(...places.subarray(at, at + 3));
  }
  return new Float32Array(dots);
}
