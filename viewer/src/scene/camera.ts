// SPDX-License-Identifier: Apache-2.0
// One camera, perspective or orthographic, that turns around a target, or looks at a plane from the front: mouse, touch
// and keys. Scene units.
import { Matrix4, OrthographicCamera, PerspectiveCamera, Quaternion, Vector2, Vector3 } from "three";

const FIELD = (30 * Math.PI) / 180;

export interface Insets { left: number; right: number; top: number; bottom: number }

export class TurningCamera {
  readonly target = new Vector3();
  readonly turn = new Quaternion();
  distance = 3;
  orthographic = false;
  plane: "up" | "down" | null = null; ///< where y grows in the plane it stays in front of
  private readonly eye = new PerspectiveCamera();
  private readonly flat = new OrthographicCamera();
  private size = new Vector2(1, 1);
  private insets: Insets = { left: 0, right: 0, top: 0, bottom: 0 };

  get camera(): PerspectiveCamera | OrthographicCamera { return this.orthographic ? this.flat : this.eye; }
  get position(): Vector3 { return new Vector3(0, 0, this.distance).applyQuaternion(this.turn).add(this.target); }
  get up(): Vector3 { return new Vector3(0, 1, 0).applyQuaternion(this.turn); }
  get right(): Vector3 { return new Vector3(1, 0, 0).applyQuaternion(this.turn); }
  get forward(): Vector3 { return new Vector3(0, 0, -1).applyQuaternion(this.turn); }
  get near(): number { return this.orthographic ? this.distance - 4 : Math.max(this.distance - 2.2, this.distance * 0.01); }
  get far(): number { return this.distance + (this.orthographic ? 4 : 2.2); }

  look(position: Vector3, target: Vector3, up: Vector3): void {
    this.target.copy(target);
    this.distance = Math.max(1e-6, position.distanceTo(target));
    if (this.plane) {
      const sign = this.plane === "up" ? 1 : -1;
      position = new Vector3(0, 0, sign * this.distance).add(target);
      up = new Vector3(0, sign, 0);
    }
    this.turn.setFromRotationMatrix(new Matrix4().lookAt(position, target, up));
  }

  resize(width: number, height: number, insets: Insets): void {
    this.size.set(width, height);
    this.insets = insets;
  }

  /// Lets all points fit into the free part of the window, seen along the present direction.
  frame(points: Float32Array, stride: number, margin: number): void {
    const right = this.right, up = this.up, back = this.forward.negate();
    const low = new Vector3(Infinity, Infinity, Infinity), high = low.clone().negate(), p = new Vector3();
    for (let i = 0; i + 2 < points.length; i += stride) {
      p.set(points[i]!, points[i + 1]!, points[i + 2]!);
      const q = new Vector3(p.dot(right), p.dot(up), p.dot(back));
      low.min(q);
      high.max(q);
    }
    const { left, right: r, top, bottom } = this.insets;
    const free = new Vector2(Math.max(1, this.size.x - left - r), Math.max(1, this.size.y - top - bottom));
    const tangent = Math.tan(FIELD / 2);
    const perHeight = this.size.y / free.y, perWidth = this.size.y / free.x;
    // Twice: perspective moves the middle of what is seen.
    const middle = low.clone().add(high).multiplyScalar(0.5);
    for (let round = 0; round < 4; ++round) {
      let need = 0, bottomMost = Infinity, topMost = -Infinity, leftMost = Infinity, rightMost = -Infinity;
      for (let i = 0; i + 2 < points.length; i += stride) {
        p.set(points[i]!, points[i + 1]!, points[i + 2]!);
        const x = p.dot(right) - middle.x, y = p.dot(up) - middle.y, z = p.dot(back) - middle.z;
        const depth = this.orthographic ? 0 : z;
        need = Math.max(need, (Math.abs(x) * perWidth) / tangent + depth, (Math.abs(y) * perHeight) / tangent + depth);
        if (round < 3) {
          const w = this.orthographic ? 1 : this.distance - z;
          leftMost = Math.min(leftMost, x / w); rightMost = Math.max(rightMost, x / w);
          bottomMost = Math.min(bottomMost, y / w); topMost = Math.max(topMost, y / w);
        }
      }
      this.distance = Math.max(1e-3, need * margin);
      if (round < 3 && round > 0) {
        const w = this.orthographic ? 1 : this.distance;
        middle.x += ((leftMost + rightMost) / 2) * w;
        middle.y += ((bottomMost + topMost) / 2) * w;
      }
    }
    this.target.set(0, 0, 0).addScaledVector(right, middle.x).addScaledVector(up, middle.y).addScaledVector(back, middle.z);
  }

  /// Brings the three.js camera up to date.
  apply(): PerspectiveCamera | OrthographicCamera {
    const { x: width, y: height } = this.size;
    const camera = this.camera;
    camera.position.copy(this.position);
    camera.quaternion.copy(this.turn);
    camera.near = this.near;
    camera.far = this.far;
    if (camera instanceof PerspectiveCamera) {
      camera.fov = (FIELD * 180) / Math.PI;
      camera.aspect = width / height;
    } else {
      const half = this.distance * Math.tan(FIELD / 2);
      camera.top = half;
      camera.bottom = -half;
      camera.right = (half * width) / height;
      camera.left = -camera.right;
    }
    const { left, right, top, bottom } = this.insets;
    camera.setViewOffset(width, height, (right - left) / 2, (bottom - top) / 2, width, height);
    camera.updateMatrixWorld();
    return camera;
  }

  /// Scene units per CSS pixel at the target.
  get perPixel(): number { return (2 * this.distance * Math.tan(FIELD / 2)) / this.size.y; }

  rotate(dx: number, dy: number): void {
    const speed = 2.4 / Math.min(this.size.x, this.size.y);
    const q = new Quaternion().setFromAxisAngle(this.up, -dx * speed);
    q.multiply(new Quaternion().setFromAxisAngle(this.right, -dy * speed));
    this.turn.premultiply(q).normalize();
  }
  roll(angle: number): void { this.turn.premultiply(new Quaternion().setFromAxisAngle(this.forward, angle)).normalize(); }
  pan(dx: number, dy: number): void { this.target.addScaledVector(this.right, -dx * this.perPixel).addScaledVector(this.up, dy * this.perPixel); }
  /// Towards what is under the pixel (x, y) of the window.
  zoom(factor: number, x: number, y: number): void {
    const before = this.perPixel;
    const next = Math.min(40, Math.max(2e-3, this.distance * factor));
    const { left, right, top, bottom } = this.insets;
    const cx = (this.size.x + left - right) / 2, cy = (this.size.y + top - bottom) / 2;
    this.distance = next;
    const change = before - this.perPixel;
    this.target.addScaledVector(this.right, (x - cx) * change).addScaledVector(this.up, -(y - cy) * change);
  }

  /// Mouse: left turns, right or with shift moves, wheel zooms. Touch: one finger turns, two move, zoom and roll. In
  /// front of a plane nothing turns: it moves.
  listen(element: HTMLElement, changed: () => void, clicked: (x: number, y: number) => void): void {
    const fingers = new Map<number, Vector2>();
    let travelled = 0, shift = false;
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      if (fingers.size === 0) {
        travelled = 0;
        shift = event.button !== 0 || event.shiftKey || event.ctrlKey;
      }
      fingers.set(event.pointerId, new Vector2(event.clientX, event.clientY));
    });
    element.addEventListener("pointermove", (event) => {
      const old = fingers.get(event.pointerId);
      if (!old) return;
      const now = new Vector2(event.clientX, event.clientY);
      travelled += now.distanceTo(old);
      if (fingers.size === 1) {
        if (travelled < 3) return;
        if (shift || this.plane) this.pan(now.x - old.x, now.y - old.y);
        else this.rotate(now.x - old.x, now.y - old.y);
      } else if (fingers.size === 2) {
        const other = [...fingers].find(([id]) => id !== event.pointerId)![1];
        const was = old.clone().sub(other), is = now.clone().sub(other), middle = now.clone().add(other).multiplyScalar(0.5);
        this.pan((now.x - old.x) / 2, (now.y - old.y) / 2);
        this.zoom(Math.max(0.2, was.length()) / Math.max(0.2, is.length()), middle.x, middle.y);
        if (!this.plane) this.roll(is.angle() - was.angle());
      }
      old.copy(now);
      changed();
    });
    const lifted = (event: PointerEvent) => {
      if (!fingers.delete(event.pointerId)) return;
      if (event.type === "pointerup" && fingers.size === 0 && travelled < 5 && !shift) clicked(event.clientX, event.clientY);
    };
    element.addEventListener("pointerup", lifted);
    element.addEventListener("pointercancel", lifted);
    element.addEventListener("contextmenu", (event) => event.preventDefault());
    element.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 18 : 1;
      this.zoom(Math.exp(Math.max(-0.5, Math.min(0.5, event.deltaY * lines * 0.0014))), event.clientX, event.clientY);
      changed();
    }, { passive: false });
  }
}
