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
import { PointSet, type Look } from "./points";

CameraControls.install({
  THREE: { Vector2, Vector3, Vector4, Quaternion, Matrix4, Spherical, Box3, Sphere, Raycaster },
});

/** While the view moves, a frame may take this long [ms]: else fewer of the points are drawn. */
const FRAME = 60;
const FIT_TO_VIEW = 1.05;

export class View {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(35, 1, 0.01, 100);
  private readonly controls: CameraControls;
  private points: PointSet | null = null;
  private surface: (Mesh | LineSegments)[] = [];
  private lines: Line[] = [];
  private place: Framed = (point) => point;
  private share = 1;
  private moving = false;
  private stale = true;
  private last = 0;
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
    for (const event of ["controlstart", "wake"] as const) this.controls.addEventListener(event, () => this.moves(true));
    for (const event of ["controlend", "sleep"] as const) this.controls.addEventListener(event, () => this.moves(false));
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement!);
    this.resize();
    requestAnimationFrame(this.frame);
  }

  /** Show these points, seen from a little above; null shows nothing. */
  cloud(cloud: Cloud | null): void {
    if (this.points) {
      this.scene.remove(this.points.object);
      this.points.dispose();
    }
    this.points = null;
    this.share = 1;
    if (cloud && cloud.n > 0) {
      this.points = new PointSet(cloud);
      this.place = framed(cloud);
      this.scene.add(this.points.object);
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
      const material = new MeshBasicMaterial({
        color: 0x9fc6e8,
        transparent: true,
        opacity: 0.16,
        side: DoubleSide,
        depthWrite: false,
      });
      this.surface = [
        new Mesh(meshOf(surface, this.place), material),
        new LineSegments(
          linesOf(surface, this.place),
          new LineBasicMaterial({ color: 0xbcd9f2, transparent: true, opacity: 0.55 }),
        ),
      ];
      this.surface.forEach((each) => this.scene.add(each));
    }
    this.touch();
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
      const line = new Line(geometry, new LineBasicMaterial({ color: 0xffffff, depthTest: false }));
      line.renderOrder = 1;
      this.scene.add(line);
      return line;
    });
    this.touch();
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
    const hidden = [...this.surface, ...this.lines];
    hidden.forEach((each) => (each.visible = false));
    this.points.picking(true);
    this.camera.setViewOffset(clientWidth, clientHeight, x, y, 1, 1);
    this.renderer.setRenderTarget(target);
    this.renderer.setClearColor(0, 0);
    this.renderer.render(this.scene, this.camera);
    const pixel = new Uint8Array(4);
    this.renderer.readRenderTargetPixels(target, 0, 0, 1, 1, pixel);
    this.renderer.setRenderTarget(null);
    this.renderer.setClearColor(0x23282e, 1);
    this.camera.clearViewOffset();
    this.points.picking(false);
    hidden.forEach((each) => (each.visible = true));
    target.dispose();
    this.touch();
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
  }

  dolly(factor: number): void {
    void this.controls.dollyTo(this.controls.distance * factor, this.controls.smoothTime > 0);
  }

  pan(x: number, y: number): void {
    void this.controls.truck(x, y, this.controls.smoothTime > 0);
  }

  /** Whether dragging turns the picture; it does not while it draws a lasso. */
  set turns(on: boolean) {
    this.controls.enabled = on;
  }

  private moves(on: boolean): void {
    this.moving = on;
    this.touch();
  }

  private touch(): void {
    this.stale = true;
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas.parentElement!;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.touch();
  }

  private readonly frame = (now: number): void => {
    requestAnimationFrame(this.frame);
    const turned = this.controls.update(Math.min(0.1, (now - this.last) / 1000));
    const took = now - this.last;
    this.last = now;
    if (turned && this.points) {
      this.share = Math.max(0.02, Math.min(1, this.share * (took > FRAME ? 0.7 : 1.1)));
      this.points.thin(this.share);
    } else if (!this.moving && this.share < 1 && this.points) {
      this.share = 1;
      this.points.thin(1);
      this.stale = true;
    }
    if (!turned && !this.stale) return;
    this.stale = false;
    this.renderer.render(this.scene, this.camera);
    this.onFrame();
  };
}
