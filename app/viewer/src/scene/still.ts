/** A picture of many points that takes several frames, kept with its depths: surfaces can be drawn into it. */

import {
  AlwaysDepth,
  BufferAttribute,
  BufferGeometry,
  DepthTexture,
  GLSL3,
  Mesh,
  RawShaderMaterial,
  WebGLRenderTarget,
  type Camera,
  type WebGLRenderer,
} from "three";
import type { PointSet } from "./points";

const VERTEX = `
in vec3 position;
out vec2 at;
void main() {
  at = 0.5 * position.xy + 0.5;
  gl_Position = vec4(position, 1.0);
}`;

const FRAGMENT = `
precision highp float;
uniform highp sampler2D seen, depths;
in vec2 at;
out vec4 color;
void main() {
  float depth = texture(depths, at).r;
  if (depth == 1.0) discard; // the ground, which three has cleared in another color space
  color = vec4(texture(seen, at).rgb, 1.0);
  gl_FragDepth = depth;
}`;

export class Still {
  /** All of the picture at once, for the scene. */
  readonly object: Mesh<BufferGeometry, RawShaderMaterial>;
  private readonly target = new WebGLRenderTarget(1, 1, { depthTexture: new DepthTexture(1, 1) });
  private drawn = 0;

  constructor() {
    const corners = Float32Array.of(-1, -1, 0, 3, -1, 0, -1, 3, 0);
    const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(corners, 3));
    const material = new RawShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      glslVersion: GLSL3,
      depthFunc: AlwaysDepth,
      uniforms: { seen: { value: this.target.texture }, depths: { value: this.target.depthTexture } },
    });
    this.object = new Mesh(geometry, material);
    this.object.frustumCulled = false;
    this.object.renderOrder = -1;
  }

  /** To be begun anew after it. */
  resize(width: number, height: number): void {
    this.target.setSize(width, height);
  }

  /** Begin anew. */
  restart(): void {
    this.drawn = 0;
  }

  /** Draw so many points more; true once all are there. */
  add(renderer: WebGLRenderer, points: PointSet, camera: Camera, n: number): boolean {
    renderer.setRenderTarget(this.target);
    renderer.autoClear = this.drawn === 0;
    points.range(this.drawn, n);
    renderer.render(points.object, camera);
    renderer.autoClear = true;
    renderer.setRenderTarget(null);
    this.drawn += n;
    return this.drawn >= points.n;
  }
}
