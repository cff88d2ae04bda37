// The path in space, to be turned by mouse, touch and keys. It is loaded when it is first looked at.

import {
  Box3, Box3Helper, BufferAttribute, BufferGeometry, CanvasTexture, Color, GridHelper, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial,
  PerspectiveCamera, Points, PointsMaterial, Scene, SphereGeometry, Sprite, SpriteMaterial, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { colour, onChange } from "../drawing";
import { canvas } from "../elements";
import { AXIS_NAMES } from "../axes";
import { madeAt } from "./flat";
import type { Moment, Shown, View } from "./picture";
import type { Segments } from "./segments";

/** What a key turns by, radians. */
const TURN = Math.PI / 24;
/** The colour of a colour of the style sheet. */
const shade = (name: string): Color => new Color(colour(name));

export class Space implements View {
  private readonly canvas = canvas("space");
  private readonly renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
  private readonly camera = new PerspectiveCamera(40, 1, 0.1, 10_000);
  private readonly controls = new OrbitControls(this.camera, this.canvas);
  private readonly scene = new Scene();
  private readonly done = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true }));
  private readonly ahead = new LineSegments(this.done.geometry, new LineBasicMaterial({ transparent: true, opacity: 0.25, vertexColors: true }));
  private readonly dots = new Points(new BufferGeometry(), new PointsMaterial({ size: 7, sizeAttenuation: false }));
  private readonly tool = new Mesh(new SphereGeometry(1), new MeshBasicMaterial());
  /** What is around the path: a grid below it, the travel, and the axes where the zero is. */
  private around = new Group();
  private isDue = false;
  private shown: Shown | undefined;
  private moment: Moment = { made: Infinity, tool: undefined };

  constructor() {
    this.camera.up.set(0, 0, 1);
    this.scene.add(this.ahead, this.done, this.dots, this.tool, this.around);
    this.controls.addEventListener("change", () => this.render());
    this.canvas.addEventListener("keydown", (event) => this.turnBy(event));
    onChange(this.canvas, () => this.shown && this.paint(this.shown));
  }

  show(shown: Shown): void {
    const isOther = shown.motion !== this.shown?.motion;
    this.shown = shown;
    const { geometry } = this.done;
    const { places, count } = shown.segments;
    geometry.setAttribute("position", new BufferAttribute(places.slice(0, 6 * count), 3));
    if (isOther) this.stand();
    this.paint(shown);
  }

  at(moment: Moment): void {
    this.moment = moment;
    if (!this.shown) return;
    const { motion, segments } = this.shown;
    const { geometry } = this.done;
    const made = moment.made >= motion.end ? segments.count : madeAt(segments, moment.made);
    this.done.onBeforeRender = () => geometry.setDrawRange(0, 2 * made);
    this.done.onAfterRender = () => geometry.setDrawRange(0, Infinity);
    geometry.setDrawRange(0, Infinity);
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

  /** Looks at the whole from the front, the right and above. */
  private stand(): void {
    if (!this.shown) return;
    const { min, max } = whole(this.shown);
    const aspect = this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1);
    const size = Math.max(min.distanceTo(max), 1) / Math.min(1, aspect);
    this.controls.target.copy(min).add(max).multiplyScalar(0.5);
    this.camera.position.copy(this.controls.target).add(new Vector3(0.75, -1.15, 0.9).multiplyScalar(size));
    [this.camera.near, this.camera.far] = [size / 1000, size * 20];
    this.tool.scale.setScalar(size / 90);
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
    this.done.geometry.setAttribute("color", new BufferAttribute(colours, 3));
    this.dots.geometry.setAttribute("position", new BufferAttribute(dotsOf(segments), 3));
    this.dots.material.color = shade("over");
    this.tool.material.color = shade("tool");
    this.surround(shown);
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
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
  }
}

const placed = ([x = 0, y = 0, z = 0]: number[]): Vector3 => new Vector3(x, y, z);

/** What is looked at: the path, or where there is none, as far as the machine can go. */
function whole({ segments: { count, low, high }, travel }: Shown): Box3 {
  return count ? new Box3(placed(low), placed(high)) : new Box3(new Vector3(), placed(travel));
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
