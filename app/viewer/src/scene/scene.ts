/** The picture: points, a surface over them, lengths; drawn when something has changed. */

import CameraControls from "camera-controls";
import {
  Box3,
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  Line,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  PerspectiveCamera,
  Points,
  Quaternion,
  Raycaster,
  Scene,
  Sphere,
  Spherical,
  Vector2,
  Vector3,
  Vector4,
  WebGLRenderTarget,
  WebGLRenderer,
} from "three";
import type { Cloud } from "../cloud";
import type { Flat, Patch } from "../geometry/kind";
import type { Vector } from "../geometry/vector";
import { framed, linesOf, meshOf, type Framed } from "./mesh";
import { POINTS, PointSet, type Look } from "./points";
import { Still } from "./still";

CameraControls.install({
  THREE: { Vector2, Vector3, Vector4, Quaternion, Matrix4, Spherical, Box3, Sphere, Raycaster },
});

/** While the view moves, a frame may take this long [ms]: else fewer of the points are drawn. */
const FRAME = 60;
/** Points in one frame, until it is known how long they take: about so many a processor draws in that time. */
const AT_ONCE = 50_000;
const FEWEST = 5_000;
const FIT_TO_VIEW = 1.05;

const SURFACE = new MeshBasicMaterial({
  color: 0x9fc6e8,
  transparent: true,
  opacity: 0.16,
  side: DoubleSide,
  depthWrite: false,
});
const RIMS = new LineBasicMaterial({ color: 0xbcd9f2, transparent: true, opacity: 0.55 });
const LENGTHS = new LineBasicMaterial({ color: 0xffffff, depthTest: false });

export class View {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(35, 1, 0.01, 100);
  private readonly controls: CameraControls;
  private points: PointSet | null = null;
  private surface: (Mesh | LineSegments)[] = [];
  private lines: Line[] = [];
  private place: Framed = (point) => point;
  private readonly still = new Still();
  private atOnce = AT_ONCE;
  private moving = false;
  /** Whether a frame is on its way. */
  private awake = false;
  /** What is not in the picture yet: the points as they are now, or only what is drawn into them. */
  private stale: "points" | "drawing" | null = "points";
  /** Whether the picture shows a sample of the points, and all are on their way. */
  private sampled = false;
  private last = 0;
  /** Whether the next frame is the first of its cloud: it is marked for who measures the page. */
  private fresh = false;
  /** Called after each frame, for what is drawn over the picture. */
  onFrame: () => void = () => {};

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.setClearColor(0x23282e);
    this.camera.up.set(0, 0, 1);
    this.controls = new CameraControls(this.camera, canvas);
    this.controls.updateCameraUp();
    this.controls.smoothTime = matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : 0.12;
    this.controls.draggingSmoothTime = 0;
    this.controls.minDistance = 0.05;
    this.controls.maxDistance = 30;
    this.scene.add(this.still.object);
    this.compile();
    for (const event of ["controlstart", "wake"] as const) this.controls.addEventListener(event, () => this.moves(true));
    for (const event of ["controlend", "sleep"] as const) this.controls.addEventListener(event, () => this.moves(false));
    for (const event of ["control", "transitionstart"] as const) this.controls.addEventListener(event, () => this.wake());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement!);
    this.resize();
  }

  /** Have all shaders ready before they are needed; whether they are right is no question of each visit. */
  private compile(): void {
    this.renderer.debug.checkShaderErrors = false;
    const [all, none] = [new Scene(), new BufferGeometry()];
    none.setAttribute("position", new BufferAttribute(new Float32Array(3), 3));
    all.add(new Points(none, POINTS), new Mesh(none, SURFACE), new LineSegments(none, RIMS), new Line(none, LENGTHS));
    this.renderer.compile(all, this.camera);
  }

  /** Show these points, seen from a little above; null shows nothing. */
  cloud(cloud: Cloud | null): void {
    if (this.points) {
      this.scene.remove(this.points.object);
      this.points.dispose();
    }
    this.points = null;
    this.atOnce = AT_ONCE;
    if (cloud && cloud.n > 0) {
      this.points = new PointSet(cloud);
      this.place = framed(cloud);
      this.scene.add(this.points.object);
      this.fresh = true;
      this.points.size(cloud.n > 100_000 ? 2 : cloud.n > 5_000 ? 3 : 5);
    }
    this.touch();
  }

  look(look: Look): void {
    this.points?.show(look);
    this.touch();
  }

  show(surface: Patch | Flat | null): void {
    for (const each of this.surface) {
      this.scene.remove(each);
      each.geometry.dispose();
    }
    this.surface = [];
    if (surface) {
      this.surface = [
        new Mesh(meshOf(surface, this.place), SURFACE),
        new LineSegments(linesOf(surface, this.place), RIMS),
      ];
      this.surface.forEach((each) => this.scene.add(each));
    }
    this.touch("drawing");
  }

  /** Straight lines between pairs of points of the file. */
  measures(pairs: readonly (readonly [Vector, Vector])[]): void {
    for (const each of this.lines) {
      this.scene.remove(each);
      each.geometry.dispose();
    }
    this.lines = pairs.map((pair) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(Float32Array.from(pair.flatMap(this.place)), 3));
      const line = new Line(geometry, LENGTHS);
      line.renderOrder = 1;
      this.scene.add(line);
      return line;
    });
    this.touch("drawing");
  }

  /** Where a point of the file is seen, in CSS pixels from the top left of the picture. */
  seen(point: Vector): readonly [number, number] {
    const at = new Vector3(...this.place(point)).project(this.camera);
    const { clientWidth, clientHeight } = this.canvas;
    return [((at.x + 1) / 2) * clientWidth, ((1 - at.y) / 2) * clientHeight];
  }

  /** The same for all points of a cloud, one after the other (2 N); NaN behind the camera. */
  seenAll(cloud: Cloud): Float64Array {
    this.camera.updateMatrixWorld();
    const { middle, size } = cloud.frame;
    const m = new Matrix4()
      .multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse)
      .elements;
    const { clientWidth, clientHeight } = this.canvas;
    const seen = new Float64Array(2 * cloud.n);
    for (let i = 0; i < cloud.n; i++) {
      const x = (cloud.xyz[3 * i] - middle[0]) / size;
      const y = (cloud.xyz[3 * i + 1] - middle[1]) / size;
      const z = (cloud.xyz[3 * i + 2] - middle[2]) / size;
      const w = m[3] * x + m[7] * y + m[11] * z + m[15];
      seen[2 * i] = w > 0 ? (((m[0] * x + m[4] * y + m[8] * z + m[12]) / w + 1) / 2) * clientWidth : NaN;
      seen[2 * i + 1] = ((1 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / w) / 2) * clientHeight;
    }
    return seen;
  }

  /** The point of the cloud that is drawn at a place of the picture, or close to it; null for none. */
  pick(x: number, y: number): number | null {
    if (!this.points) return null;
    const { clientWidth, clientHeight } = this.canvas;
    const target = new WebGLRenderTarget(1, 1);
    this.points.range(0, this.points.n);
    this.points.picking(true);
    this.camera.setViewOffset(clientWidth, clientHeight, x, y, 1, 1);
    this.renderer.setRenderTarget(target);
    this.renderer.setClearColor(0, 0);
    this.renderer.render(this.points.object, this.camera);
    const pixel = new Uint8Array(4);
    this.renderer.readRenderTargetPixels(target, 0, 0, 1, 1, pixel);
    this.renderer.setRenderTarget(null);
    this.renderer.setClearColor(0x23282e, 1);
    this.camera.clearViewOffset();
    this.points.picking(false);
    target.dispose();
    return this.points.point(pixel[0] + 256 * (pixel[1] + 256 * (pixel[2] + 256 * pixel[3])));
  }

  /** From a little above, all of it. */
  home(): void {
    void this.controls.setLookAt(2, -2.6, 1.6, 0, 0, 0, false);
    void this.controls.fitToSphere(new Sphere(new Vector3(), FIT_TO_VIEW), this.controls.smoothTime > 0);
    this.touch();
  }

  /** Turn by angles [rad], or come closer by a factor: for the keyboard. */
  turn(azimuth: number, polar: number): void {
    void this.controls.rotate(azimuth, polar, this.controls.smoothTime > 0);
    this.wake();
  }

  dolly(factor: number): void {
    void this.controls.dollyTo(this.controls.distance * factor, this.controls.smoothTime > 0);
    this.wake();
  }

  pan(x: number, y: number): void {
    void this.controls.truck(x, y, this.controls.smoothTime > 0);
    this.wake();
  }

  /** Whether dragging turns the picture; it does not while it draws around points. */
  set turns(on: boolean) {
    this.controls.enabled = on;
  }

  private moves(on: boolean): void {
    this.moving = on;
    this.wake();
  }

  /** See to it that frames are drawn, until there is nothing new to draw. */
  private wake(): void {
    if (this.awake) return;
    this.awake = true;
    this.last = performance.now();
    requestAnimationFrame(this.frame);
  }

  private touch(what: "points" | "drawing" = "points"): void {
    if (this.stale !== "points") this.stale = what;
    this.wake();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas.parentElement!;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.still.resize(this.canvas.width, this.canvas.height);
    const before = this.controls.getDistanceToFitSphere(FIT_TO_VIEW);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.keepInView(this.controls.getDistanceToFitSphere(FIT_TO_VIEW) / before);
    this.touch();
  }

  /** Come closer or go away by a factor, so that as much is seen in a picture of another shape. */
  private keepInView(factor: number): void {
    const goal = this.controls.getSpherical(new Spherical(), true).radius;
    if (factor !== 1) void this.controls.dollyTo(goal * factor, false);
  }

  private readonly frame = (now: number): void => {
    const took = now - this.last;
    this.last = now;
    const turned = this.controls.update(Math.min(0.1, took / 1000));
    if (turned) {
      const all = this.points?.n ?? AT_ONCE;
      this.atOnce = Math.max(FEWEST, Math.min(all, this.atOnce * (took > FRAME ? 0.7 : 1.1)));
      this.stale = "points";
    }
    if (this.stale === "points") this.drawSample();
    else if (this.sampled && !this.moving) this.drawMore();
    else if (this.stale === "drawing") this.draw();
    this.awake = turned || (this.sampled && !this.moving);
    if (this.awake) requestAnimationFrame(this.frame);
  };

  /** Some of the points at once, which are all of them in a cloud of ordinary size. */
  private drawSample(): void {
    const [n, atOnce] = [this.points?.n ?? 0, Math.ceil(this.atOnce)];
    this.sampled = n > atOnce;
    this.points?.range(0, Math.min(n, atOnce));
    this.still.restart();
    this.draw(false);
  }

  private drawMore(): void {
    if (!this.points || !this.still.add(this.renderer, this.points, this.camera, AT_ONCE)) return;
    this.sampled = false;
    this.draw(true);
  }

  /** Points, as they are or as the still has them, with all that stands among them. */
  private draw(still = this.still.object.visible): void {
    this.stale = null;
    this.still.object.visible = still;
    if (this.points) this.points.object.visible = !still;
    this.renderer.render(this.scene, this.camera);
    if (this.points) this.points.object.visible = true;
    if (this.fresh) performance.mark("points");
    this.fresh = false;
    this.onFrame();
  }
}
