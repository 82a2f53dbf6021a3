/** Points on the GPU: three int16 for the place, one for the value, and a byte that says what it is. */

import {
  BufferAttribute,
  BufferGeometry,
  Color as ThreeColor,
  Points,
  RawShaderMaterial,
  GLSL3,
  Sphere,
} from "three";
import type { Cloud } from "../cloud";
import { LABELS, PLAIN, RAMP, type Color } from "./colors";

const FULL = 32767;

/** What the color of a point tells. */
export type Coloring = "residual" | "inlier" | "label" | "kind" | "plain";
/** Their numbers in the shader; a kind is one more label. */
const NUMBERS: Record<Coloring, number> = { plain: 0, residual: 1, inlier: 2, label: 3, kind: 3 };

export interface Look {
  /** Signed values (N), and the one at which the colors end. */
  readonly values: Float64Array | null;
  readonly limit: number;
  readonly inliers: Uint8Array | null;
  readonly labels: Int32Array | null;
  /** 1 for points that are set apart: selected, or of the chosen segment. */
  readonly chosen: Uint8Array | null;
  readonly coloring: Coloring;
}

const VERTEX = `
precision highp float;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform float size;
uniform int coloring, hasChosen;
uniform vec3 ramp[${RAMP.length}], kinds[${LABELS.length}], plain;
uniform bool picking;
in vec3 position;
in float value;
in uvec2 mark;
out vec3 tint;
flat out uint outline;
flat out uint number;
vec3 ramped(float v) {
  float place = (clamp(v, -1.0, 1.0) + 1.0) * 0.5 * float(${RAMP.length - 1});
  int i = min(int(place), ${RAMP.length - 2});
  return mix(ramp[i], ramp[i + 1], place - float(i));
}
void main() {
  bool outlier = (mark.x & 1u) != 0u;
  bool chosen = (mark.x & 2u) != 0u;
  tint = coloring == 1 ? ramped(value) : coloring == 3 ? kinds[int(mark.y)] : plain;
  if (coloring == 2) tint = outlier ? vec3(0.902, 0.624, 0.0) : vec3(0.337, 0.706, 0.914);
  if (hasChosen == 1 && !chosen) tint = mix(tint, vec3(0.2, 0.22, 0.25), 0.75);
  outline = outlier && coloring != 3 ? 1u : 0u;
  number = uint(gl_VertexID);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_PointSize = picking ? 7.0 : outline == 1u ? size * 1.8 + 2.0 : size;
}`;

const FRAGMENT = `
precision highp float;
uniform bool picking;
in vec3 tint;
flat in uint outline;
flat in uint number;
out vec4 color;
void main() {
  float r = length(gl_PointCoord - 0.5) * 2.0;
  if (r > 1.0 || (outline == 1u && r < 0.55 && !picking)) discard;
  if (picking) {
    uint n = number + 1u;
    color = vec4(float(n & 255u), float((n >> 8) & 255u), float((n >> 16) & 255u), float((n >> 24) & 255u)) / 255.0;
  } else color = vec4(tint, 1.0);
}`;

const flat = (colors: readonly Color[]): ThreeColor[] => colors.map((each) => new ThreeColor().setRGB(...each));

/** Of all clouds, one after the other: made once, it is compiled once. */
export const POINTS = new RawShaderMaterial({
  vertexShader: VERTEX,
  fragmentShader: FRAGMENT,
  glslVersion: GLSL3,
  uniforms: {
    size: { value: 3 },
    coloring: { value: 0 },
    hasChosen: { value: 0 },
    picking: { value: false },
    ramp: { value: flat(RAMP) },
    kinds: { value: flat(LABELS) },
    plain: { value: flat([PLAIN])[0] },
  },
});

export class PointSet {
  readonly object: Points<BufferGeometry, RawShaderMaterial>;
  /** From the point at one place to that at the next: the first of them are a fair sample. */
  private readonly step: number;

  constructor(private readonly cloud: Cloud) {
    const { middle, size } = cloud.frame;
    this.step = stepThrough(cloud.n);
    const places = new Int16Array(3 * cloud.n);
    const [x, y, z] = middle;
    const scale = FULL / size;
    for (let i = 0, point = 0; i < cloud.n; i++, point = this.after(point)) {
      places[3 * i] = Math.round(scale * (cloud.xyz[3 * point] - x));
      places[3 * i + 1] = Math.round(scale * (cloud.xyz[3 * point + 1] - y));
      places[3 * i + 2] = Math.round(scale * (cloud.xyz[3 * point + 2] - z));
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(places, 3, true));
    geometry.setAttribute("value", new BufferAttribute(new Int16Array(cloud.n), 1, true));
    geometry.setAttribute("mark", whole(new Uint8Array(2 * cloud.n)));
    geometry.boundingSphere = new Sphere(undefined, 1);
    this.object = new Points(geometry, POINTS);
    this.object.frustumCulled = false;
  }

  /** The point at the place after that of another. */
  private after(point: number): number {
    const next = point + this.step;
    return next < this.cloud.n ? next : next - this.cloud.n;
  }

  show({ values, limit, inliers, labels, chosen, coloring }: Look): void {
    const { value, mark } = this.object.geometry.attributes as Record<string, BufferAttribute>;
    const [shown, marks] = [value.array as Int16Array, mark.array as Uint8Array];
    for (let i = 0, point = 0; i < this.cloud.n; i++, point = this.after(point)) {
      if (values) {
        const share = limit > 0 ? values[point] / limit || 0 : 0;
        shown[i] = FULL * Math.max(-1, Math.min(1, share));
      }
      marks[2 * i] = (inliers && !inliers[point] ? 1 : 0) | (chosen?.[point] ? 2 : 0);
      marks[2 * i + 1] = labels ? labels[point] % LABELS.length : 0;
    }
    value.needsUpdate = mark.needsUpdate = true;
    const { uniforms } = this.object.material;
    uniforms.coloring.value = NUMBERS[coloring];
    uniforms.hasChosen.value = Number(chosen !== null);
  }

  get n(): number {
    return this.cloud.n;
  }

  /** Draw only so many of the points, a sample of them all. */
  range(from: number, n: number): void {
    this.object.geometry.setDrawRange(from, n);
  }

  size(pixels: number): void {
    this.object.material.uniforms.size.value = pixels;
  }

  picking(on: boolean): void {
    this.object.material.uniforms.picking.value = on;
  }

  /** The point that was drawn as this number, from 1; null for none. */
  point(drawn: number): number | null {
    return drawn > 0 && drawn <= this.cloud.n ? ((drawn - 1) * this.step) % this.cloud.n : null;
  }

  dispose(): void {
    this.object.geometry.dispose();
  }
}

/** An attribute that the shader sees as whole numbers. */
function whole(marks: Uint8Array): BufferAttribute {
  const attribute = new BufferAttribute(marks, 2);
  (attribute as BufferAttribute & { gpuType: number }).gpuType = INT;
  return attribute;
}
const INT = 1013; // three's IntType

/** A step through n places that comes to each once, and to all parts of them early: n over the golden ratio. */
function stepThrough(n: number): number {
  const common = (a: number, b: number): number => (b ? common(b, a % b) : a);
  let step = Math.max(1, Math.round(n / 1.618034));
  while (common(step, n) > 1) step++;
  return step;
}
