// SPDX-License-Identifier: Apache-2.0
// The renderer. A picture is made when something changed, in three steps: axis to a texture with depth, eye-dome
// lighting to the screen, glass over it.
import { BufferAttribute, BufferGeometry, DepthTexture, FloatType, Group, Mesh, Scene, UnsignedIntType, Vector2, Vector3, WebGLRenderer, WebGLRenderTarget } from "three";
import { rgb } from "../colours";
import { PageError } from "../data";
import { TurningCamera, type Insets } from "./camera";
import { limits, paperMaterial, screenMaterial, sharedUniforms } from "./materials";

export const PAPER = { light: { top: "ffffff", bottom: "e9ecf0" }, dark: { top: "1b1f26", bottom: "0e1014" } };

export class Stage {
  readonly canvas: HTMLCanvasElement;
  readonly camera = new TurningCamera();
  readonly shared = sharedUniforms();
  readonly opaque = new Scene();
  readonly overlay = new Scene();
  readonly depth: DepthTexture;
  private readonly renderer: WebGLRenderer;
  private readonly target: WebGLRenderTarget;
  private readonly screen: Scene;
  readonly paper: Scene; ///< under everything
  private readonly screenUniforms;
  private readonly paperUniforms = { top: { value: new Vector3() }, bottom: { value: new Vector3() } };
  private size = new Vector2(1, 1);
  private pending = false;
  private frames = 0;
  onFrame: () => void = () => {};

  constructor(parent: HTMLElement) {
    try {
      this.renderer = new WebGLRenderer({ antialias: true, powerPreference: "high-performance" });
    } catch {
      throw new PageError("This browser shows no 3D graphics (WebGL 2); switch on hardware acceleration or use another browser.");
    }
    limits.textureSize = this.renderer.capabilities.maxTextureSize;
    this.renderer.autoClear = false;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    parent.append(this.canvas);
    this.depth = new DepthTexture(1, 1, FloatType);
    if (!this.renderer.extensions.has("EXT_color_buffer_float")) this.depth.type = UnsignedIntType;
    this.target = new WebGLRenderTarget(1, 1, { samples: 4, depthTexture: this.depth });
    this.screenUniforms = {
      picture: { value: this.target.texture }, depth: { value: this.depth }, viewport: this.shared.viewport, perspective: this.shared.perspective,
      nearFar: { value: new Vector2(0.1, 10) }, strength: { value: 1 }, radius: { value: 1.4 },
    };
    const all = (material: ReturnType<typeof screenMaterial>) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(Float32Array.from([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
      const mesh = new Mesh(geometry, material);
      mesh.frustumCulled = false;
      const scene = new Scene();
      scene.add(mesh);
      return scene;
    };
    this.screen = all(screenMaterial(this.screenUniforms));
    this.paper = all(paperMaterial(this.paperUniforms));
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.onLost("The graphics card gave up on this page (too large for it, or it was busy); reload it.");
    });
  }
  onLost: (message: string) => void = () => {};

  get pixelRatio(): number { return this.renderer.getPixelRatio(); }
  get width(): number { return this.size.x; }
  get height(): number { return this.size.y; }
  get drawn(): number { return this.frames; }

  add(group: Group, scene = this.opaque): void { scene.add(group); }

  /// What is shown is flat: seen from the front, without light.
  set plane(y: "up" | "down" | null) {
    this.camera.plane = y;
    this.shared.flat_.value = Number(y !== null);
    this.canvas.setAttribute("aria-label", `Picture of the medial axis; drag to ${y ? "move" : "turn"}, scroll to zoom, click to pick`);
  }

  resize(width: number, height: number, insets: Insets): void {
    this.size.set(Math.max(1, width), Math.max(1, height));
    this.renderer.setSize(this.size.x, this.size.y);
    const pixels = this.renderer.getDrawingBufferSize(new Vector2());
    this.target.setSize(pixels.x, pixels.y);
    this.shared.viewport.value.copy(pixels);
    this.camera.resize(this.size.x, this.size.y, insets);
    this.invalidate();
  }

  setPaper(dark: boolean): void {
    const paper = dark ? PAPER.dark : PAPER.light;
    this.paperUniforms.top.value.set(...rgb(paper.top));
    this.paperUniforms.bottom.value.set(...rgb(paper.bottom));
    this.shared.paper.value.set(...rgb(dark ? "16191f" : "f2f4f6"));
    this.screenUniforms.strength.value = this.camera.plane ? 0 : dark ? 32 : 24;
  }

  invalidate(): void {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => this.draw());
  }

  draw(): void {
    this.pending = false;
    this.onFrame();
    const camera = this.camera.apply();
    this.shared.perspective.value = this.camera.orthographic ? 0 : 1;
    this.shared.sceneOfView.value.copy(camera.matrixWorld);
    this.screenUniforms.nearFar.value.set(camera.near, camera.far);
    this.screenUniforms.radius.value = 1.3 * this.pixelRatio;
    const r = this.renderer;
    r.setRenderTarget(this.target);
    r.clear();
    r.render(this.paper, camera);
    r.render(this.opaque, camera);
    r.setRenderTarget(null);
    r.clear();
    r.render(this.screen, camera);
    r.render(this.overlay, camera);
    ++this.frames;
  }

  /// Drawn and read at once: the buffer is not kept between frames.
  picture(): string {
    this.draw();
    return this.canvas.toDataURL("image/png");
  }
}
