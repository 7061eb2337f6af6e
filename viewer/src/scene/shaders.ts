// SPDX-License-Identifier: Apache-2.0
// The shaders. Vertices lie in textures (position and radius, the measure shown, burn times), so every kind of primitive
// reads them by number: a new colouring is one upload, a new range none.

const VERTEX_DATA = /* glsl */ `
  uniform highp sampler2D vertexPlace;   // x, y, z in scene units, radius
  uniform highp sampler2D vertexValue;   // the measure shown
  uniform highp sampler2D vertexTime;    // burn time on sheets, on curves
  ivec2 texelOf(int i) { return ivec2(i & 2047, i >> 11); }
  vec4 placeOf(int i) { return texelFetch(vertexPlace, texelOf(i), 0); }
  float valueOf(int i) { return texelFetch(vertexValue, texelOf(i), 0).r; }
  vec2 timesOf(int i) { return texelFetch(vertexTime, texelOf(i), 0).rg; }
`;

// Clipping, burning and colour of a fragment; the light of a two-sided matte surface.
const FRAGMENT = /* glsl */ `
  precision highp float;
  uniform sampler2D colourMap;
  uniform vec2 range;          // of the measure
  uniform vec3 missingColour, infiniteColour;
  uniform vec4 clipPlane;      // scene units; fragments with a positive distance go
  uniform float clipOn;
  uniform vec4 burn;           // on, time, width of the front, hide
  uniform vec3 paper;          // background
  uniform float flat_;         // of the plane: no light
  vec3 colourOf(float value) {
    if (value > 1e20) return infiniteColour;
    if (value < -1e20) return missingColour;
    float t = (value - range.x) / max(range.y - range.x, 1e-30);
    return texture(colourMap, vec2(clamp(t, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
  }
  void clip(vec3 scene) { if (clipOn > 0.5 && dot(vec4(scene, 1.0), clipPlane) > 0.0) discard; }
  // What has burned is gone or dim; the fire itself glows.
  vec3 burned(vec3 colour, float time, out float glow) {
    glow = 0.0;
    if (burn.x < 0.5) return colour;
    float behind = (burn.y - time) / burn.z; // in widths of the front
    if (time > 1e20) return colour;
    if (behind > 1.0 && burn.w > 0.5) discard;
    glow = 1.0 - smoothstep(0.0, 1.0, abs(behind));
    float gone = smoothstep(0.0, 1.0, behind);
    return mix(colour, mix(paper, vec3(dot(colour, vec3(0.3, 0.6, 0.1))), 0.3), gone * 0.92);
  }
  vec3 lit(vec3 colour, vec3 normal, vec3 toEye, float gloss) {
    if (flat_ > 0.5) return colour;
    vec3 n = dot(normal, toEye) < 0.0 ? -normal : normal;
    float key = max(dot(n, normalize(vec3(0.45, 0.7, 0.75))), 0.0);
    float fill = max(dot(n, normalize(vec3(-0.75, 0.1, 0.5))), 0.0);
    float head = max(dot(n, toEye), 0.0);
    float light = 0.34 + 0.46 * key + 0.14 * fill + 0.22 * head;
    vec3 halfway = normalize(normalize(vec3(0.45, 0.7, 0.75)) + toEye);
    float spark = gloss * pow(max(dot(n, halfway), 0.0), 40.0);
    return pow(pow(colour, vec3(2.2)) * light * light * 1.25 + spark, vec3(1.0 / 2.2));
  }
  const vec3 FLAME = vec3(1.0, 0.55, 0.12), HOT = vec3(1.0, 0.93, 0.62);
  vec3 inFlames(vec3 colour, float glow) { return mix(colour, mix(FLAME, HOT, glow), smoothstep(0.0, 0.6, glow)); }
`;

// The colour of a part by its number, in a map of so many colours (colours.ts).
const CATEGORY = /* glsl */ `
  float categoryOf(uint part) { return (float(part % 12u) + 0.5) / 12.0; }
`;

/// By vertices, or by corners: then with a normal (zero: that of the triangle), a level and the number of a part each.
export const surfaceVertex = (corners: boolean) => /* glsl */ `
  ${VERTEX_DATA}
  ${CATEGORY}
  ${corners ? "in uint corner; in float level; in float part;" : ""}
  uniform float byPart; // 1: its number, 2: its value
  uniform highp sampler2D partValue;
  out vec3 vScene; out vec3 vView; out vec3 vNormal; out float vValue; out float vTime; out float vLevel;${corners ? " flat out float vPart;" : ""}
  void main() {
    ${corners ? "vPart = part;" : ""}
    int v = ${corners ? "int(corner)" : "gl_VertexID"};
    vec4 place = placeOf(v);
    vScene = place.xyz;
    vec4 view = viewMatrix * vec4(place.xyz, 1.0);
    vView = view.xyz;
    vNormal = ${corners ? "mat3(viewMatrix) * normal" : "vec3(0.0)"};
    vLevel = ${corners ? "level" : "0.0"};
    vValue = ${corners ? "byPart > 1.5 ? texelFetch(partValue, texelOf(int(part)), 0).r : byPart > 0.5 ? categoryOf(uint(part)) : valueOf(v)" : "valueOf(v)"};
    vTime = timesOf(v).x;
    gl_Position = projectionMatrix * view;
  }
`;

export const surfaceFragment = (corners: boolean) => /* glsl */ `
  ${FRAGMENT}
  uniform float perspective, least;
  ${corners ? "flat in float vPart; uniform float chosen;" : ""}
  uniform vec3 plain; uniform float usePlain;
  in vec3 vScene; in vec3 vView; in vec3 vNormal; in float vValue; in float vTime; in float vLevel;
  out vec4 colour;
  void main() {
    clip(vScene);
    if (vLevel < least) discard;
    float glow;
    vec3 base = usePlain > 0.5 ? plain : colourOf(vValue);
    base = burned(base, vTime, glow);
    ${corners ? "if (chosen > -0.5 && abs(vPart - chosen) > 0.5) base = mix(base, paper, 0.6);" : ""}
    vec3 flat_ = cross(dFdx(vView), dFdy(vView));
    vec3 normal = normalize(dot(vNormal, vNormal) > 0.25 ? vNormal : flat_);
    vec3 toEye = perspective > 0.5 ? normalize(-vView) : vec3(0.0, 0.0, 1.0);
    colour = vec4(inFlames(lit(base, normal, toEye, 0.05), glow), 1.0);
  }
`;

// Triangles with places and normals of their own, and the values of vertices.
export const slabVertex = /* glsl */ `
  ${VERTEX_DATA}
  in uint corner;
  out vec3 vScene; out vec3 vView; out vec3 vNormal; out float vValue; out float vTime; out float vLevel;
  void main() {
    vScene = position;
    vec4 view = viewMatrix * vec4(position, 1.0);
    vView = view.xyz;
    vNormal = mat3(viewMatrix) * normal;
    vLevel = 0.0;
    vValue = valueOf(int(corner));
    vTime = timesOf(int(corner)).x;
    gl_Position = projectionMatrix * view;
  }
`;

// Segments as round bars of some pixels: a rectangle around each, shaded like a tube.
export const barVertex = /* glsl */ `
  ${VERTEX_DATA}
  ${CATEGORY}
  in uvec3 ends;           // and the number of a part from 1 on, or 0
  uniform float byPart;
  uniform vec2 viewport;   // pixels
  uniform float halfWidth; // pixels, at least
  uniform float halfWorld; // scene units, at least
  uniform float bias;      // towards the eye, of the depth range
  uniform float onCurves;  // which burn time
  out vec3 vScene; out vec2 vPixel; flat out vec2 vA; flat out vec2 vB; out float vHalf; out float vValue; out float vTime;
  void main() {
    vec4 a = placeOf(int(ends.x)), b = placeOf(int(ends.y));
    vec4 ca = projectionMatrix * (viewMatrix * vec4(a.xyz, 1.0)), cb = projectionMatrix * (viewMatrix * vec4(b.xyz, 1.0));
    bool first = position.x < 0.5;
    vec4 mine = first ? ca : cb;
    // Behind the eye, or parts that coincide: nothing to see.
    if (ca.w <= 0.0 || cb.w <= 0.0 || a.xyz == b.xyz) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
    vA = (ca.xy / ca.w * 0.5 + 0.5) * viewport;
    vB = (cb.xy / cb.w * 0.5 + 0.5) * viewport;
    vHalf = max(halfWidth, halfWorld * projectionMatrix[1][1] / mine.w * viewport.y * 0.5);
    vec2 along = vB - vA;
    along = dot(along, along) > 1e-8 ? normalize(along) : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x);
    float reach = vHalf + 1.0;
    vPixel = (first ? vA - along * reach : vB + along * reach) + across * position.y * reach;
    vScene = first ? a.xyz : b.xyz;
    int i = int(first ? ends.x : ends.y);
    vValue = byPart > 0.5 && ends.z > 0u ? categoryOf(ends.z - 1u) : valueOf(i);
    vec2 times = timesOf(i);
    vTime = onCurves > 0.5 && times.y > -1e20 ? times.y : times.x;
    gl_Position = vec4((vPixel / viewport * 2.0 - 1.0) * mine.w, mine.z - bias * mine.w, mine.w);
  }
`;

export const barFragment = /* glsl */ `
  ${FRAGMENT}
  uniform vec3 plain; uniform float usePlain; uniform float round_; uniform float opacity;
  in vec3 vScene; in vec2 vPixel; flat in vec2 vA; flat in vec2 vB; in float vHalf; in float vValue; in float vTime;
  out vec4 colour;
  void main() {
    clip(vScene);
    vec2 ab = vB - vA, ap = vPixel - vA;
    float t = clamp(dot(ap, ab) / max(dot(ab, ab), 1e-6), 0.0, 1.0);
    vec2 off = ap - ab * t;
    float far = length(off), cover = clamp(vHalf - far + 0.5, 0.0, 1.0);
    if (cover * opacity <= 0.0) discard;
    float glow;
    vec3 base = usePlain > 0.5 ? plain : colourOf(vValue);
    base = burned(base, vTime, glow);
    // Bent around the line only, also at the round ends: else every joint would be a bead.
    vec2 along = dot(ab, ab) > 1e-4 ? normalize(ab) : vec2(0.0);
    vec2 s = (ap - along * dot(ap, along)) / max(vHalf, 1.0);
    vec3 normal = vec3(s, sqrt(max(0.0, 1.0 - dot(s, s))));
    vec3 shaded = round_ > 0.5 ? lit(base, normal, vec3(0.0, 0.0, 1.0), 0.18) : base;
    colour = vec4(inFlames(shaded, glow), cover * opacity);
  }
`;

// Tubes: the balls between two places, met by the ray through the pixel (src/picture/tube.cpp has the formulas). The
// rectangle covers them on the screen.
export const tubeVertex = /* glsl */ `
  ${VERTEX_DATA}
  ${CATEGORY}
  in uvec3 ends;           // and the number of a part from 1 on, or 0
  uniform float byPart, perspective;
  uniform vec2 viewport;   // pixels
  uniform float halfWidth; // pixels, at least
  uniform float more;      // pixels, beyond the radius
  flat out vec3 vA; flat out vec3 vB; flat out vec2 vRadii; flat out vec2 vValues;
  void main() {
    vec4 pa = placeOf(int(ends.x)), pb = placeOf(int(ends.y));
    vA = (viewMatrix * vec4(pa.xyz, 1.0)).xyz; vB = (viewMatrix * vec4(pb.xyz, 1.0)).xyz;
    vec4 ca = projectionMatrix * vec4(vA, 1.0), cb = projectionMatrix * vec4(vB, 1.0);
    if (ca.w <= 0.0 || cb.w <= 0.0) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
    vec2 perPixel = 2.0 / (projectionMatrix[1][1] * viewport.y) * (perspective > 0.5 ? vec2(-vA.z, -vB.z) : vec2(1.0));
    vRadii = max(vec2(pa.w, pb.w), halfWidth * perPixel) + more * perPixel;
    float category = categoryOf(ends.z - 1u);
    vValues = byPart > 0.5 && ends.z > 0u ? vec2(category) : vec2(valueOf(int(ends.x)), valueOf(int(ends.y)));
    // The outline of a ball is wider than its radius where the eye is near.
    vec2 away = perspective > 0.5 ? vec2(-vA.z, -vB.z) : vec2(1e9);
    vec2 pixels = vRadii / perPixel * away / max(away - vRadii, 0.02 * away);
    float reach = max(pixels.x, pixels.y) + 1.5;
    vec2 a = (ca.xy / ca.w * 0.5 + 0.5) * viewport, b = (cb.xy / cb.w * 0.5 + 0.5) * viewport, along = b - a;
    along = dot(along, along) > 1e-8 ? normalize(along) : vec2(1.0, 0.0);
    bool first = position.x < 0.5;
    vec4 mine = first ? ca : cb;
    vec2 at = (first ? a - along * reach : b + along * reach) + vec2(-along.y, along.x) * position.y * reach;
    gl_Position = vec4((at / viewport * 2.0 - 1.0) * mine.w, mine.z, mine.w);
  }
`;

export const tubeFragment = /* glsl */ `
  ${FRAGMENT}
  uniform mat4 projectionMatrix, sceneOfView;
  uniform float perspective;
  uniform vec2 viewport;
  uniform vec3 plain; uniform float usePlain;
  flat in vec3 vA; flat in vec3 vB; flat in vec2 vRadii; flat in vec2 vValues;
  out vec4 colour;
  void main() {
    vec2 at = (gl_FragCoord.xy / viewport * 2.0 - 1.0 + (perspective > 0.5 ? projectionMatrix[2].xy : -projectionMatrix[3].xy)) / vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
    vec3 ray = perspective > 0.5 ? normalize(vec3(at, -1.0)) : vec3(0.0, 0.0, -1.0);
    // From a place on the ray near the tube, so that numbers are small; lengths in radii.
    float before = dot(0.5 * (vA + vB) - (perspective > 0.5 ? vec3(0.0) : vec3(at, 0.0)), ray), unit = vRadii.x + vRadii.y;
    vec3 start = (perspective > 0.5 ? vec3(0.0) : vec3(at, 0.0)) + before * ray;
    vec3 from = (start - vA) / unit, u = (vB - vA) / unit;
    float r = vRadii.x / unit, grow = (vRadii.y - vRadii.x) / unit, room = dot(u, u) - grow * grow;
    // How far beside it the ray goes by.
    vec3 uAcross = u - ray * dot(u, ray), fromAcross = from - ray * dot(from, ray);
    float s = clamp(dot(fromAcross, uAcross) / max(dot(uAcross, uAcross), 1e-12), 0.0, 1.0);
    vec3 off = fromAcross - s * uAcross;
    float perPixel = 2.0 / (projectionMatrix[1][1] * viewport.y) * (perspective > 0.5 ? -start.z : 1.0) / unit;
    float cover = clamp(0.5 - (length(off) - r - s * grow) / perPixel, 0.0, 1.0);
    float t = dot(s * u - from, ray), inside;
    vec3 normal = normalize(off);
    bool met = false;
    if (room > 0.0) {
      float p = dot(u, ray), q = dot(u, from) + r * grow;
      float square = room - p * p, linear = room * dot(ray, from) - q * p, rest = room * (dot(from, from) - r * r) - q * q;
      inside = linear * linear - square * rest;
      if (square != 0.0 && inside >= 0.0) {
        float first = (-linear - sqrt(inside)) / square, share = (q + first * p) / room;
        if (share > 0.0 && share < 1.0) { met = true; t = first; s = share; normal = normalize(from + t * ray - s * u); }
      }
    }
    if (!met) {
      float nearest = 1e30;
      for (int i = 0; i < 2; ++i) {
        float k = float(i), radius = r + k * grow;
        vec3 o = from - k * u;
        float half_ = dot(o, ray);
        inside = half_ * half_ - dot(o, o) + radius * radius;
        if (inside < 0.0 || -half_ - sqrt(inside) > nearest) continue;
        nearest = t = -half_ - sqrt(inside);
        s = k;
        normal = normalize(o + t * ray);
        cover = 1.0;
      }
    }
    if (cover <= 0.0) discard;
    vec3 hit = start + t * unit * ray;
    clip((sceneOfView * vec4(hit, 1.0)).xyz);
    vec4 place = projectionMatrix * vec4(hit, 1.0);
    gl_FragDepth = clamp(place.z / place.w * 0.5 + 0.5, 0.0, 1.0);
    vec3 base = usePlain > 0.5 ? plain : colourOf(mix(vValues.x, vValues.y, s));
    colour = vec4(lit(base, normal, -ray, 0.18), cover);
  }
`;

// Balls: a square around each, the ray through the pixel meets the ball.
export const ballVertex = /* glsl */ `
  ${VERTEX_DATA}
  in uint centre;
  uniform float scale;        // of the radius of the vertex
  uniform float fixedPixels;  // or so many pixels
  uniform float perspective;
  uniform float onCurves;
  uniform vec2 viewport;
  out vec3 vAt; flat out vec3 vCentre; flat out float vRadius; flat out float vValue; flat out float vTime;
  void main() {
    vec4 place = placeOf(int(centre));
    vec4 view = viewMatrix * vec4(place.xyz, 1.0);
    float perPixel = 2.0 / (projectionMatrix[1][1] * viewport.y) * (perspective > 0.5 ? -view.z : 1.0);
    float r = fixedPixels > 0.0 ? fixedPixels * perPixel : place.w * scale;
    vCentre = view.xyz; vRadius = r;
    vValue = valueOf(int(centre));
    vec2 times = timesOf(int(centre));
    vTime = onCurves > 0.5 && times.y > -1e20 ? times.y : times.x;
    // The square stands across the line of sight, far enough in front to cover the outline of the ball.
    vec3 toEye = perspective > 0.5 ? normalize(-view.xyz) : vec3(0.0, 0.0, 1.0);
    vec3 right = normalize(cross(vec3(0.0, 1.0, 0.0), toEye)), up = cross(toEye, right);
    float d = length(view.xyz);
    float grow = perspective > 0.5 ? d / sqrt(max(d * d - r * r, d * d * 0.01)) : 1.0;
    vAt = view.xyz + (right * position.x + up * position.y) * r * grow * 1.02;
    gl_Position = projectionMatrix * vec4(vAt, 1.0);
  }
`;

export const ballFragment = /* glsl */ `
  ${FRAGMENT}
  uniform mat4 projectionMatrix;
  uniform mat4 sceneOfView;
  uniform float perspective;
  uniform vec3 plain; uniform float usePlain; uniform float opacity;
  in vec3 vAt; flat in vec3 vCentre; flat in float vRadius; flat in float vValue; flat in float vTime;
  out vec4 colour;
  void main() {
    vec3 origin = perspective > 0.5 ? vec3(0.0) : vec3(vAt.xy, 0.0);
    vec3 ray = perspective > 0.5 ? normalize(vAt) : vec3(0.0, 0.0, -1.0);
    vec3 oc = vCentre - origin;
    float along = dot(oc, ray);
    float miss = dot(oc, oc) - along * along, inside = vRadius * vRadius - miss;
    if (inside < 0.0) discard;
    vec3 hit = origin + ray * (along - sqrt(inside));
    vec3 normal = (hit - vCentre) / vRadius;
    if (clipOn > 0.5 && dot(vec4((sceneOfView * vec4(hit, 1.0)).xyz, 1.0), clipPlane) > 0.0) {
      hit = origin + ray * (along + sqrt(inside)); // the far side, seen through the cut
      normal = (vCentre - hit) / vRadius;
      clip((sceneOfView * vec4(hit, 1.0)).xyz);
    }
    float glow;
    vec3 base = usePlain > 0.5 ? plain : colourOf(vValue);
    base = burned(base, vTime, glow);
    vec4 at = projectionMatrix * vec4(hit, 1.0);
    gl_FragDepth = clamp(at.z / at.w * 0.5 + 0.5, 0.0, 1.0);
    // Glass balls are clearer in the middle.
    float rim = pow(1.0 - abs(dot(normal, ray)), 2.0);
    if (flat_ > 0.5) rim = smoothstep(2.5, 1.5, (vRadius - sqrt(miss)) / max(fwidth(vAt.x), 1e-30)); // a circle
    float solid = flat_ > 0.5 ? clamp((vRadius - sqrt(miss)) / max(fwidth(vAt.x), 1e-30), 0.0, 1.0) : 1.0;
    colour = vec4(inFlames(lit(base, normal, -ray, 0.12), glow), opacity < 1.0 ? mix(opacity, 0.85, rim) : solid);
  }
`;

// The shape around: glass, seen where it turns away.
export const glassVertex = /* glsl */ `
  in float value; // what it may be coloured by
  out vec3 vScene; out vec3 vView; out vec3 vNormal; out float vValue;
  void main() {
    vScene = position;
    vValue = value;
    vec4 view = viewMatrix * vec4(position, 1.0);
    vView = view.xyz;
    vNormal = mat3(viewMatrix) * normal;
    gl_Position = projectionMatrix * view;
  }
`;

const SHAPE_COLOUR = /* glsl */ `
  uniform sampler2D shapeMap;
  uniform vec2 shapeRange;
  vec3 shapeColour(float value) {
    if (abs(value) > 1e20) return value > 0.0 ? infiniteColour : missingColour;
    float t = (value - shapeRange.x) / max(shapeRange.y - shapeRange.x, 1e-30);
    return texture(shapeMap, vec2(clamp(t, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb;
  }
`;

export const glassFragment = /* glsl */ `
  ${FRAGMENT}
  ${SHAPE_COLOUR}
  uniform highp sampler2D behind; // depth of what is drawn already
  uniform vec2 viewport;
  uniform float perspective, opacity, byValue;
  uniform vec3 tint, rim;
  in vec3 vScene; in vec3 vView; in vec3 vNormal; in float vValue;
  out vec4 colour;
  void main() {
    clip(vScene);
    if (texture(behind, gl_FragCoord.xy / viewport).r < gl_FragCoord.z) discard;
    vec3 toEye = perspective > 0.5 ? normalize(-vView) : vec3(0.0, 0.0, 1.0);
    vec3 n = normalize(vNormal);
    float facing = abs(dot(n, toEye));
    float edge = pow(1.0 - facing, 2.6);
    float key = 0.5 + 0.5 * dot(n * sign(dot(n, toEye)), normalize(vec3(0.45, 0.7, 0.75)));
    colour = vec4(mix(tint * (0.75 + 0.25 * key), rim, edge), clamp((0.10 + 0.75 * edge) * opacity, 0.0, 1.0));
    if (byValue > 0.5) colour = vec4(lit(shapeColour(vValue), n, toEye, 0.05), clamp((0.35 + 0.65 * edge) * opacity, 0.0, 1.0));
  }
`;

// The shape with the colours of a measure, as sheets are drawn.
export const skinFragment = /* glsl */ `
  ${FRAGMENT}
  ${SHAPE_COLOUR}
  uniform float perspective;
  in vec3 vScene; in vec3 vView; in vec3 vNormal; in float vValue;
  out vec4 colour;
  void main() {
    clip(vScene);
    vec3 toEye = perspective > 0.5 ? normalize(-vView) : vec3(0.0, 0.0, 1.0);
    colour = vec4(lit(shapeColour(vValue), normalize(vNormal), toEye, 0.05), 1.0);
  }
`;

// A shape of the plane.
export const fillFragment = /* glsl */ `
  precision highp float;
  uniform vec3 tint; uniform float opacity;
  out vec4 colour;
  void main() { colour = vec4(tint, opacity); }
`;

// Eye-dome lighting (after Boucheny): what lies behind its neighbours on the screen is darker, so sheets that are flat
// and of one colour stand apart.
export const screenVertex = /* glsl */ `
  out vec2 vAt;
  void main() { vAt = position.xy * 0.5 + 0.5; gl_Position = vec4(position.xy, 0.0, 1.0); }
`;

export const screenFragment = /* glsl */ `
  precision highp float;
  uniform sampler2D picture; uniform highp sampler2D depth;
  uniform vec2 viewport; uniform vec2 nearFar; uniform float perspective, strength, radius;
  in vec2 vAt;
  out vec4 colour;
  float distanceAt(vec2 at) {
    float z = texture(depth, at).r;
    float n = nearFar.x, f = nearFar.y;
    return perspective > 0.5 ? log2(n * f / (f - z * (f - n))) : (n + z * (f - n));
  }
  float occlusion(vec2 at, float here, float reach) {
    float sum = 0.0;
    for (int i = 0; i < 8; ++i) {
      float angle = 0.7853981634 * float(i) + 0.3;
      vec2 step_ = vec2(cos(angle), sin(angle)) * reach / viewport;
      if (texture(depth, at + step_).r >= 1.0) continue;
      sum += min(max(0.0, here - distanceAt(at + step_)), 0.05);
    }
    return sum / 8.0;
  }
  void main() {
    vec3 drawn = texture(picture, vAt).rgb;
    float z = texture(depth, vAt).r, shade = 1.0;
    if (z < 1.0) {
      float here = distanceAt(vAt);
      shade = exp(-strength * (occlusion(vAt, here, radius) + 0.6 * occlusion(vAt, here, 4.0 * radius)));
    }
    colour = vec4(drawn * shade, 1.0);
  }
`;

export const paperFragment = /* glsl */ `
  precision highp float;
  uniform vec3 top, bottom;
  in vec2 vAt;
  out vec4 colour;
  void main() { colour = vec4(mix(bottom, top, smoothstep(0.0, 1.0, vAt.y)), 1.0); }
`;
