/**
 * The shaders of a lit material. Light is linear throughout: albedo is decoded by the texture unit, the sum is encoded at the end.
 *
 * Diffuse by Lambert; gloss by Cook and Torrance with the distribution of Trowbridge and Reitz (GGX), the masking of Smith in
 * Schlick's approximation, and Schlick's Fresnel term. `SURFACE` draws the picture flat: places are pixels of the stage, x to the
 * right, y down, z to the eye, which is far away. `SOLID` draws it around a solid that heights raise: y up, the eye 4 radii away.
 */

export const CORNERS = `#version 300 es
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}`;

const MATERIAL = `#version 300 es
precision highp float;

uniform sampler2D albedo, normal, roughness, metallic, ao, height;
uniform vec2 corner;    // of the picture, px of the stage
uniform vec2 extent;    // of one tile
uniform float tiles;    // along each axis
uniform float tall;     // px of the stage
uniform vec3 lamp;
uniform float power;
uniform float up;       // 1: green of the normals points up the picture, -1: down
uniform float relief;   // px of the picture that white of the height stands for; 0: take the normals
out vec4 seen;

const float PI = 3.14159265359;

vec4 look(sampler2D map, vec2 at);

// The normal at a place of the picture: x to the right, y down, z out of it.
vec3 slope(vec2 at) {
  if (relief == 0.0) {
    vec3 n = look(normal, at).xyz * 2.0 - 1.0;
    return normalize(vec3(n.x, -n.y * up, max(n.z, 1e-3)));
  }
  vec2 step = 1.0 / vec2(textureSize(height, 0));
  vec3 rows, columns;
  for (int k = -1; k <= 1; k += 1) {
    float weight = k == 0 ? 0.5 : 0.25;
    vec2 along = float(k) * step;
    columns[k + 1] = weight * (look(height, at + vec2(step.x, along.y)).r - look(height, at + vec2(-step.x, along.y)).r);
    rows[k + 1] = weight * (look(height, at + vec2(along.x, step.y)).r - look(height, at + vec2(along.x, -step.y)).r);
  }
  vec2 rise = 0.5 * relief * vec2(dot(columns, vec3(1.0)), dot(rows, vec3(1.0)));
  return normalize(vec3(-rise, 1.0));
}

vec3 encoded(vec3 light) {
  vec3 c = clamp(light, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

// What a surface of normal n sends to v of the light that comes from l.
vec3 sent(vec3 base, float rough, float metal, vec3 n, vec3 v, vec3 l) {
  vec3 h = normalize(l + v);
  float nl = max(dot(n, l), 0.0), nv = max(dot(n, v), 1e-3), nh = max(dot(n, h), 0.0), vh = max(dot(v, h), 0.0);
  vec3 straight = mix(vec3(0.04), base, metal);
  vec3 fresnel = straight + (1.0 - straight) * pow(1.0 - vh, 5.0);
  float a = rough * rough;
  float spread = nh * nh * (a * a - 1.0) + 1.0;
  float facets = a * a / (PI * spread * spread);
  float k = (rough + 1.0) * (rough + 1.0) / 8.0;
  float unmasked = 1.0 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k) * 4.0);
  vec3 gloss = fresnel * facets * unmasked;
  vec3 matt = (1.0 - fresnel) * (1.0 - metal) * base / PI;
  return (matt + gloss) * nl * PI;
}
`;

export const SURFACE = `${MATERIAL}
const float SKY = 0.045;  // light from everywhere

vec4 look(sampler2D map, vec2 at) { return texture(map, at); }

void main() {
  vec2 place = vec2(gl_FragCoord.x, tall - gl_FragCoord.y);
  vec2 at = (place - corner) / extent;
  vec4 base = look(albedo, at);
  vec3 n = slope(at);
  float rough = clamp(look(roughness, at).r, 0.05, 1.0);
  float metal = look(metallic, at).r;
  float open = look(ao, at).r;
  if (at.x < 0.0 || at.y < 0.0 || at.x >= tiles || at.y >= tiles) {
    seen = vec4(0.0);
    return;
  }
  vec3 way = lamp - vec3(place, 0.0);
  float fading = lamp.z * lamp.z / dot(way, way);
  vec3 light = sent(base.rgb, rough, metal, n, vec3(0.0, 0.0, 1.0), normalize(way)) * power * fading;
  seen = vec4(encoded(light + base.rgb * SKY * power * open) * base.a, base.a);
}`;

/** What a material can be seen on; the first is the picture itself. */
export const SHAPES = /** @type {const} */ (["flat", "plane", "ball", "cylinder", "corner"]);

export const SOLID = `${MATERIAL}
uniform int shape;      // its number in SHAPES
uniform mat3 turn;      // from the eye's directions to those of the solid
uniform float depth;    // how far black of the height lies below white, in radii

const vec3 UP = vec3(0.0, 1.0, 0.0);
float lod = 0.0;

vec4 look(sampler2D map, vec2 at) { return textureLod(map, at, lod); }

// Distances from the faces that the picture covers, as white of the height leaves them, and from those that end the solid.
vec2 faces(vec3 p) {
  if (shape == 1) return vec2(p.y, max(max(abs(p.x), abs(p.z)) - 1.0, -p.y - depth - 0.06));
  if (shape == 2) return vec2(length(p) - 0.85, -1.0);
  return vec2((shape == 3 ? length(p.xz) : max(abs(p.x), abs(p.z))) - 0.6, abs(p.y) - 0.75);
}

// Place of the texture: rows go down, a square of it is as high as it is wide.
vec2 spot(vec3 p) {
  vec2 at;
  if (shape == 1) at = vec2(p.x, p.z) * 0.5 + 0.5;
  else if (shape == 2) at = vec2(atan(p.x, p.z) / PI, acos(clamp(p.y / length(p), -1.0, 1.0)) / PI);
  else if (shape == 3) at = vec2(1.5 * atan(p.x, p.z) / PI, (0.75 - p.y) * 0.8);
  else at = 0.8 * vec2(abs(p.x) > abs(p.z) ? sign(p.x) * (1.2 - p.z) : p.z > 0.0 ? p.x : 2.4 - p.x, 0.75 - p.y);
  return vec2(at.x, at.y * extent.x / extent.y) * tiles;
}

vec2 raised(vec3 p) {
  vec2 far = faces(p);
  if (far.x < 0.02 && depth > 0.0) far.x += depth * (1.0 - look(height, spot(p)).r);
  return far;
}

float beyond(vec3 p) {
  vec2 far = raised(p);
  return max(far.x, far.y);
}

vec3 upright(vec3 p, vec2 of) {
  vec2 e = vec2(1e-3, 0.0);
  vec3 after = vec3(dot(of, faces(p + e.xyy)), dot(of, faces(p + e.yxy)), dot(of, faces(p + e.yyx)));
  return normalize(after - vec3(dot(of, faces(p - e.xyy)), dot(of, faces(p - e.yxy)), dot(of, faces(p - e.yyx))));
}

// Light from all around: a bright window in a room that is darker below; the rougher the surface, the softer.
vec3 room(vec3 d, float rough) {
  vec3 walls = mix(vec3(0.10, 0.09, 0.08), vec3(0.42, 0.45, 0.50), smoothstep(-0.3 - rough, 0.4 + rough, d.y));
  vec2 q = abs(d.xy / max(d.z, 0.05) - vec2(-0.9, 0.9));
  float soft = 0.05 + 0.6 * rough;
  float window = (1.0 - smoothstep(0.45 - soft, 0.45 + soft, q.x)) * (1.0 - smoothstep(0.55 - soft, 0.55 + soft, q.y));
  return walls + 3.0 / (1.0 + 9.0 * rough) * window * step(0.0, d.z);
}

void main() {
  float radius = 0.5 * min(extent.x, extent.y);
  vec2 centre = corner + 0.5 * extent;
  vec2 q = (vec2(gl_FragCoord.x, tall - gl_FragCoord.y) - centre) / radius * vec2(1.0, -1.0);
  lod = max(0.0, log2(float(textureSize(albedo, 0).x) * tiles / (1.7 * radius)));
  vec3 eye = turn * vec3(0.0, 0.0, 4.0), ray = turn * normalize(vec3(q, -4.0));
  float t = 2.0, far = 1.0;
  for (int k = 0; k < 160 && far > 4e-4 && t < 6.5; k += 1) {
    far = beyond(eye + t * ray);
    t += (depth == 0.0 ? 1.0 : far > 0.02 ? 0.9 : 0.4) * far;
  }
  seen = vec4(0.0);
  if (t >= 6.5) return;
  vec3 p = eye + t * ray, v = -ray;
  vec2 at = spot(p), ends = raised(p);
  bool cap = ends.y > ends.x;  // what the picture does not cover
  vec3 n = upright(p, cap ? vec2(0.0, 1.0) : vec2(1.0, 0.0));
  vec4 base = look(albedo, at);
  if (cap) base.rgb = vec3(0.18);
  else {
    vec3 along = shape == 1 ? vec3(1.0, 0.0, 0.0) : normalize(cross(UP, n) + vec3(1e-6, 0.0, 0.0)), s = slope(at);
    n = normalize(along * s.x - cross(n, along) * s.y + n * s.z);
  }
  float rough = cap ? 0.8 : clamp(look(roughness, at).r, 0.05, 1.0), metal = cap ? 0.0 : look(metallic, at).r, open = look(ao, at).r;

  // the lamp that is dragged, with the shadows that heights throw; one that fills from the left, one from behind
  vec3 way = turn * (vec3((lamp.xy - centre) * vec2(1.0, -1.0), lamp.z) / radius) - p, l = normalize(way);
  float fading = min(1.0, lamp.z * lamp.z / (radius * radius * dot(way, way))), lit = 1.0;
  for (int k = 1; k <= 20 && depth > 0.0; k += 1) lit = min(lit, smoothstep(-0.012, 0.004, beyond(p + n * 0.01 + l * depth * 0.15 * float(k))));
  vec3 light = sent(base.rgb, rough, metal, n, v, l) * power * fading * lit;
  light += sent(base.rgb, rough, metal, n, v, turn * normalize(vec3(-0.7, 0.15, 0.5))) * 0.12 * power;
  light += sent(base.rgb, rough, metal, n, v, turn * normalize(vec3(0.6, 0.4, -0.7))) * 0.3 * power;

  // the room, by the fit of Karis (2014) to what it sends on average
  vec4 r = rough * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float nv = max(dot(n, v), 0.0), grazing = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
  vec3 straight = mix(vec3(0.04), base.rgb, metal), back = transpose(turn) * reflect(-v, n);
  light += room(back, rough) * (straight * (r.z - 1.04 * grazing) + r.w + 1.04 * grazing) * open * 0.6 * power;
  light += room(transpose(turn) * n, 1.0) * base.rgb * (1.0 - metal) * open * 0.25 * power;
  seen = vec4(encoded(light), 1.0);
}`;
