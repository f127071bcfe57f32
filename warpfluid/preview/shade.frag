#version 300 es
// One level of the shadows, from the one above it: how much light from above reaches it, as two bytes.
precision highp float;
precision highp sampler3D;

uniform sampler3D density;   // axes (y, z, x)
uniform sampler2D above;     // the level above, axes (x, z); everywhere 1 over the first
uniform vec3 size;           // of the stored part (x, y, z) [voxel of the run]
uniform vec3 toLight;        // direction, upwards
uniform vec3 levels;         // of the shadows (x, y, z)
uniform float level;         // counted from the floor
uniform float peak, extinction;
out vec2 reaching;

void main() {
  vec3 here = vec3(gl_FragCoord.x, level + 0.5, gl_FragCoord.y) / levels;
  vec3 step = toLight / toLight.y / size * (size.y / levels.y);
  vec3 middle = here + 0.5 * step, next = here + step;
  bool inside = all(greaterThan(next.xz, vec2(0))) && all(lessThan(next.xz, vec2(1)));
  vec2 bytes = texture(above, next.xz).rg;
  float before = inside && level + 1.0 < levels.y ? bytes.r + bytes.g / 255.0 : 1.0;
  bool full = all(greaterThan(middle, vec3(0))) && all(lessThan(middle, vec3(1)));
  float light = full ? texture(density, middle.yzx).r * peak : 0.0;
  float left = before * exp(-extinction * light * length(step * size));
  float coarse = floor(left * 255.0) / 255.0;
  reaching = vec2(coarse, (left - coarse) * 255.0);
}
