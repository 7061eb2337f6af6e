// SPDX-License-Identifier: Apache-2.0
// Materials and the uniforms they share: one value changed here changes everything that is drawn.
import { DataTexture, DoubleSide, GLSL3, LinearFilter, NearestFilter, RawShaderMaterial, RedFormat, RGBAFormat, FloatType, RGFormat, Vector2, Vector3, Vector4, Matrix4, type IUniform, type ShaderMaterialParameters } from "three";
import { GREY, INFINITE, rgb, textureOf } from "../colours";
import { PageError } from "../data";
import * as glsl from "./shaders";

export const TEXTURE_WIDTH = 2048;
export const limits = { textureSize: 4096 }; ///< of the graphics card; the stage knows it

/// A texture with a value per vertex; `components` 1, 2 or 4.
export function vertexTexture(count: number, components: 1 | 2 | 4): DataTexture {
  const rows = Math.max(1, Math.ceil(count / TEXTURE_WIDTH));
  if (rows > limits.textureSize) throw new PageError(`This graphics card takes at most ${limits.textureSize * TEXTURE_WIDTH} vertices, the result has ${count}; write the page with a smaller --max-triangles.`);
  const data = new Float32Array(rows * TEXTURE_WIDTH * components);
  const texture = new DataTexture(data, TEXTURE_WIDTH, rows, components === 1 ? RedFormat : components === 2 ? RGFormat : RGBAFormat, FloatType);
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

export type Uniforms = Record<string, IUniform>;

export function sharedUniforms() {
  const map = () => {
    const texture = new DataTexture(textureOf("viridis"), 256, 1);
    texture.minFilter = texture.magFilter = LinearFilter;
    texture.needsUpdate = true;
    return { value: texture };
  };
  return {
    colourMap: map(),
    shapeMap: map(), ///< of the surface
    range: { value: new Vector2(0, 1) },
    missingColour: { value: new Vector3(...GREY) },
    infiniteColour: { value: new Vector3(...INFINITE) },
    clipPlane: { value: new Vector4(1, 0, 0, 0) },
    clipOn: { value: 0 },
    burn: { value: new Vector4(0, 0, 1, 0) },
    paper: { value: new Vector3(1, 1, 1) },
    viewport: { value: new Vector2(1, 1) },
    perspective: { value: 1 },
    flat_: { value: 0 },
    sceneOfView: { value: new Matrix4() },
  };
}
export type SharedUniforms = ReturnType<typeof sharedUniforms>;

function material(vertexShader: string, fragmentShader: string, uniforms: Uniforms, more: ShaderMaterialParameters = {}): RawShaderMaterial {
  // Raw: the names three.js would add are declared here.
  const prelude = "precision highp float; precision highp int;\nuniform mat4 viewMatrix, projectionMatrix; in vec3 position; in vec3 normal;\n";
  return new RawShaderMaterial({ vertexShader: prelude + vertexShader, fragmentShader, uniforms, glslVersion: GLSL3, side: DoubleSide, ...more });
}

export const surfaceMaterial = (shared: SharedUniforms, own: Uniforms, corners: boolean) =>
  // Lines on the sheets win over the sheets.
  material(glsl.surfaceVertex(corners), glsl.surfaceFragment(corners), { ...shared, ...own }, { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });

export const slabMaterial = (shared: SharedUniforms, own: Uniforms) => material(glsl.slabVertex, glsl.surfaceFragment(false), { ...shared, ...own });

/// Thick bars are solid with smooth outlines, thin ones blend.
export const barMaterial = (shared: SharedUniforms, own: Uniforms, solid: boolean) =>
  material(glsl.barVertex, glsl.barFragment, { ...shared, ...own }, solid ? { alphaToCoverage: true } : { transparent: true, depthWrite: false });

export const tubeMaterial = (shared: SharedUniforms, own: Uniforms) => material(glsl.tubeVertex, glsl.tubeFragment, { ...shared, ...own }, { alphaToCoverage: true });

export const ballMaterial = (shared: SharedUniforms, own: Uniforms, transparent: boolean) =>
  material(glsl.ballVertex, glsl.ballFragment, { ...shared, ...own }, { transparent, depthWrite: !transparent, alphaToCoverage: !transparent });

export const glassMaterial = (own: Uniforms) => material(glsl.glassVertex, glsl.glassFragment, own, { transparent: true, depthWrite: true });

export const skinMaterial = (own: Uniforms) => material(glsl.glassVertex, glsl.skinFragment, own);

export const fillMaterial = (own: Uniforms) => material(glsl.glassVertex, glsl.fillFragment, own, { transparent: true, depthTest: false, depthWrite: false });

export const screenMaterial = (own: Uniforms) => material(glsl.screenVertex, glsl.screenFragment, own, { depthTest: false, depthWrite: false });

export const paperMaterial = (own: Uniforms) => material(glsl.screenVertex, glsl.paperFragment, own, { depthTest: false, depthWrite: false });

export const colour = (hex: string) => new Vector3(...rgb(hex));
