/**
 * The shaders of a lit material. Light is linear throughout: albedo is decoded by the texture unit, the sum is encoded at the end.
 *
 * Places are pixels of the stage: x to the right, y down, z to the eye. The surface is flat but for its normals; the eye is far
 * away, the lamp is near. Diffuse by Lambert; gloss by Cook and Torrance with the distribution of Trowbridge and Reitz (GGX),
 * the masking of Smith in Schlick's approximation, and Schlick's Fresnel term.
 */

export const CORNERS = `#version 300 es
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}`;

export const SURFACE = `#version 300 es
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
const float SKY = 0.045;  // light from everywhere

vec3 slope(vec2 at) {
  if (relief == 0.0) {
    vec3 n = texture(normal, at).xyz * 2.0 - 1.0;
    return normalize(vec3(n.x, -n.y * up, max(n.z, 1e-3)));
  }
  vec2 step = 1.0 / vec2(textureSize(height, 0));
  vec3 rows, columns;
  for (int k = -1; k <= 1; k += 1) {
    float weight = k == 0 ? 0.5 : 0.25;
    vec2 along = float(k) * step;
    columns[k + 1] = weight * (texture(height, at + vec2(step.x, along.y)).r - texture(height, at + vec2(-step.x, along.y)).r);
    rows[k + 1] = weight * (texture(height, at + vec2(along.x, step.y)).r - texture(height, at + vec2(along.x, -step.y)).r);
  }
  vec2 rise = 0.5 * relief * vec2(dot(columns, vec3(1.0)), dot(rows, vec3(1.0)));
  return normalize(vec3(-rise, 1.0));
}

vec3 encoded(vec3 light) {
  vec3 c = clamp(light, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

void main() {
  vec2 place = vec2(gl_FragCoord.x, tall - gl_FragCoord.y);
  vec2 at = (place - corner) / extent;
  vec4 base = texture(albedo, at);
  vec3 n = slope(at);
  float rough = clamp(texture(roughness, at).r, 0.05, 1.0);
  float metal = texture(metallic, at).r;
  float open = texture(ao, at).r;
  if (at.x < 0.0 || at.y < 0.0 || at.x >= tiles || at.y >= tiles) {
    seen = vec4(0.0);
    return;
  }
  vec3 way = lamp - vec3(place, 0.0);
  float fading = lamp.z * lamp.z / dot(way, way);
  vec3 l = normalize(way);
  vec3 v = vec3(0.0, 0.0, 1.0);
  vec3 h = normalize(l + v);
  float nl = max(dot(n, l), 0.0), nv = max(dot(n, v), 1e-3), nh = max(dot(n, h), 0.0), vh = max(dot(v, h), 0.0);

  vec3 straight = mix(vec3(0.04), base.rgb, metal);
  vec3 fresnel = straight + (1.0 - straight) * pow(1.0 - vh, 5.0);
  float a = rough * rough;
  float spread = nh * nh * (a * a - 1.0) + 1.0;
  float facets = a * a / (PI * spread * spread);
  float k = (rough + 1.0) * (rough + 1.0) / 8.0;
  float unmasked = 1.0 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k) * 4.0);
  vec3 gloss = fresnel * facets * unmasked;
  vec3 matt = (1.0 - fresnel) * (1.0 - metal) * base.rgb / PI;

  vec3 light = (matt + gloss) * nl * power * PI * fading + base.rgb * SKY * power * open;
  seen = vec4(encoded(light) * base.a, base.a);
}`;
