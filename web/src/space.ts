// The path in space, to be turned by mouse, touch and keys. It is loaded when it is first looked at.

import {
  BufferAttribute, BufferGeometry, Color, GridHelper, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, PerspectiveCamera, Points,
  PointsMaterial, Scene, SphereGeometry, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { canvas } from "./elements";
import { colour, onChange } from "./drawing";
import { madeAt } from "./flat";
import type { Picture, Shown } from "./path";
import type { Segments } from "./segments";

/** What a key turns by, radians. */
const TURN = Math.PI / 24;
/** The colour of a colour of the style sheet. */
const shade = (name: string): Color => new Color(colour(name));

export class Space implements Picture {
  private readonly canvas = canvas("space");
  private readonly renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
  private readonly camera = new PerspectiveCamera(40, 1, 0.1, 10_000);
  private readonly controls = new OrbitControls(this.camera, this.canvas);
  private readonly scene = new Scene();
  private readonly done = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true }));
  private readonly ahead = new LineSegments(this.done.geometry, new LineBasicMaterial({ transparent: true, opacity: 0.25, vertexColors: true }));
  private readonly dots = new Points(new BufferGeometry(), new PointsMaterial({ size: 7, sizeAttenuation: false }));
  private readonly tool = new Mesh(new SphereGeometry(1), new MeshBasicMaterial());
  private grid: GridHelper | undefined;
  private shown: Shown | undefined;
  private time = 0;

  constructor() {
    this.camera.up.set(0, 0, 1);
    this.scene.add(this.ahead, this.done, this.dots, this.tool);
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

  at(time: number): void {
    this.time = time;
    if (!this.shown) return;
    const { motion, segments } = this.shown;
    this.done.geometry.setDrawRange(0, Infinity);
    const made = time >= motion.end ? segments.count : madeAt(segments, time);
    this.done.onBeforeRender = () => this.done.geometry.setDrawRange(0, 2 * made);
    this.done.onAfterRender = () => this.done.geometry.setDrawRange(0, Infinity);
    this.tool.visible = !motion.isHomingAt(time);
    this.tool.position.set(...(motion.places(time) as [number, number, number]));
    this.render();
  }

  hide(isHidden: boolean): void {
    this.canvas.hidden = isHidden;
  }

  file(): Promise<Blob | null> {
    // What was drawn is there until the page is shown.
    this.render();
    return new Promise((resolve) => this.canvas.toBlob(resolve));
  }

  /** Looks at the whole from the front, the right and above. */
  private stand(): void {
    if (!this.shown) return;
    const { low, high } = this.shown.segments;
    const [from, to] = [new Vector3(...low), new Vector3(...high)];
    const aspect = this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1);
    const size = Math.max(from.distanceTo(to), 1) / Math.min(1, aspect);
    this.controls.target.copy(from.clone().add(to).multiplyScalar(0.5));
    this.camera.position.copy(this.controls.target).add(new Vector3(0.75, -1.15, 0.9).multiplyScalar(size));
    [this.camera.near, this.camera.far] = [size / 1000, size * 20];
    this.tool.scale.setScalar(size / 90);
    this.controls.update();
  }

  /** Takes the colours of the present light, and the size of the canvas. */
  private paint({ segments, tone }: Shown): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const shades = tone.colours.map(shade);
    const colours = new Float32Array(6 * segments.count);
    for (let index = 0; index < segments.count; index++) {
      const { r, g, b } = shades[segments.ranks[index] ?? 0] ?? shade("ink");
      colours.set([r, g, b, r, g, b], 6 * index);
    }
    this.done.geometry.setAttribute("color", new BufferAttribute(colours, 3));
    this.dots.geometry.setAttribute("position", new BufferAttribute(dotsOf(segments), 3));
    this.dots.material.color = shade("over");
    this.tool.material.color = shade("tool");
    this.lay(segments.low, segments.high);
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.at(this.time);
  }

  /** A grid below the path. */
  private lay(low: number[], high: number[]): void {
    this.grid?.removeFromParent();
    this.grid?.dispose();
    const wide = Math.max((high[0] ?? 0) - (low[0] ?? 0), (high[1] ?? 0) - (low[1] ?? 0), 1) * 1.15;
    this.grid = new GridHelper(wide, 10, shade("bound"), shade("grid"));
    this.grid.rotateX(Math.PI / 2);
    this.grid.position.set(((low[0] ?? 0) + (high[0] ?? 0)) / 2, ((low[1] ?? 0) + (high[1] ?? 0)) / 2, low[2] ?? 0);
    this.scene.add(this.grid);
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

  private render(): void {
    this.renderer.render(this.scene, this.camera);
  }
}

/** Where lines have no length: places where the speed jumps. */
function dotsOf({ places, count }: Segments): Float32Array {
  const dots: number[] = [];
  for (let at = 0; at < 6 * count; at += 6) {
    const [x = 0, y = 0, z = 0, ...to] = places.slice(at, at + 6);
    if (x === to[0] && y === to[1] && z === to[2]) dots.push(x, y, z);
  }
  return new Float32Array(dots);
}
