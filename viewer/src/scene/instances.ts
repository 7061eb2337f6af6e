// SPDX-License-Identifier: Apache-2.0
// Instanced bars (segments) and balls. Their buffers grow when needed and are then written in place.
import { BufferAttribute, DynamicDrawUsage, InstancedBufferAttribute, InstancedBufferGeometry, Mesh, type RawShaderMaterial } from "three";

class Instances {
  readonly mesh: Mesh<InstancedBufferGeometry, RawShaderMaterial>;
  protected numbers: Uint32Array<ArrayBuffer> = new Uint32Array(0);
  constructor(material: RawShaderMaterial, corners: number[], private readonly attribute: string, private readonly size: number) {
    const geometry = new InstancedBufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(Float32Array.from(corners), 3));
    geometry.setIndex([0, 1, 2, 2, 1, 3]);
    geometry.instanceCount = 0;
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.reserve(256);
  }
  protected reserve(count: number): void {
    if (this.numbers.length >= count * this.size) return;
    let capacity = Math.max(256, this.numbers.length / this.size);
    while (capacity < count) capacity *= 2;
    this.numbers = new Uint32Array(capacity * this.size);
    // A new size needs a new buffer on the card.
    this.mesh.geometry.dispose();
    const attribute = new InstancedBufferAttribute(this.numbers, this.size);
    attribute.setUsage(DynamicDrawUsage);
    this.mesh.geometry.setAttribute(this.attribute, attribute);
  }
  protected upload(count: number): void {
    const attribute = this.mesh.geometry.getAttribute(this.attribute) as InstancedBufferAttribute;
    attribute.clearUpdateRanges();
    if (count > 0) attribute.addUpdateRange(0, count * this.size);
    attribute.needsUpdate = count > 0;
    this.mesh.geometry.instanceCount = count;
  }
  get count(): number { return this.mesh.geometry.instanceCount; }
}

export class Bars extends Instances {
  constructor(material: RawShaderMaterial) {
    super(material, [0, -1, 0, 1, -1, 0, 0, 1, 0, 1, 1, 0], "ends", 3);
  }
  /// `part`: per edge the number of its part; -1: none.
  write(edges: Uint32Array, list: Uint32Array, count: number, part: Int32Array | null = null): void {
    this.reserve(count);
    for (let i = 0; i < count; ++i) {
      const e = list[i]!;
      this.numbers[3 * i] = edges[2 * e]!;
      this.numbers[3 * i + 1] = edges[2 * e + 1]!;
      this.numbers[3 * i + 2] = part ? part[e]! + 1 : 0;
    }
    this.upload(count);
  }
}

export class Balls extends Instances {
  constructor(material: RawShaderMaterial) {
    super(material, [-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0], "centre", 1);
  }
  write(list: ArrayLike<number>, count: number): void {
    this.reserve(count);
    for (let i = 0; i < count; ++i) this.numbers[i] = list[i]!;
    this.upload(count);
  }
}
