#version 300 es
// Adds up light along parallel rays. Samples lie on the voxel planes that a ray crosses fastest, so that a view along
// the floor is Joseph's projection: the ray sum of the reconstruction, up to interpolation.
precision highp float;
precision highp sampler3D;

uniform sampler3D density;   // axes (y, z, x), as it lies in memory
uniform sampler2D ramp;
uniform vec3 low, high;      // corners of the stored part, from the middle of the box (x, y, z) [voxel of the run]
uniform vec3 cells;          // its voxels (x, y, z)
uniform vec3 right, up, forward;
uniform vec2 middle;         // of the picture [pixel]
uniform float scale;         // pixels a voxel
uniform float peak;          // grey levels of the number 1 in the texture
uniform float gain;          // exposure: what a ray sum is multiplied with, 1 shows 255 as white
uniform float absorption;    // optical depth of a ray whose sum is 255; 0 for light alone
uniform sampler3D shade;     // how much light from above reaches a place, as two bytes, axes (x, z, y)
uniform vec2 lamps;          // light from above and from all around; 0 where the medium glows by itself
uniform vec3 background;
uniform sampler2D solids, depths;  // what stands in the volume: colour and cover, and how far along forward
uniform int fine;            // samples a pixel and axis of these; 0 where nothing stands
uniform float reach;         // depth [voxel] that 0 to 1 spans, from -reach to reach
out vec4 colour;

// The colour of a sum of light; that of a medium which is lit stands for as much of the pixel as it hides.
vec3 look(float sum, float clear) {
  float cover = lamps.x > 0.0 ? max(1.0 - clear, 1e-4) : 1.0;
  float level = clamp(sum * gain / 255.0 / cover, 0.0, 1.0), entries = float(textureSize(ramp, 0).x);
  return cover * texture(ramp, vec2((floor(level * (entries - 1.0) + 0.5) + 0.5) / entries, 0.5)).rgb;
}

// The mean colour of a pixel's solids, the share that they cover, and the nearest of them.
vec4 stand(out float nearest) {
  vec4 total = vec4(0);
  nearest = 1e9;
  for (int i = 0; i < fine * fine; ++i) {
    ivec2 at = fine * ivec2(gl_FragCoord.xy) + ivec2(i % fine, i / fine);
    vec4 solid = texelFetch(solids, at, 0);
    total += solid / float(fine * fine);
    if (solid.a > 0.0) nearest = min(nearest, (2.0 * texelFetch(depths, at, 0).r - 1.0) * reach);
  }
  return vec4(total.rgb / max(total.a, 1e-3), total.a);
}

float passing(float depth) { return depth > 1e-3 ? (1.0 - exp(-depth)) / depth : 1.0 - 0.5 * depth; }

void main() {
  vec2 at = (gl_FragCoord.xy - middle) / scale;
  vec3 start = at.x * right + at.y * up;
  vec3 edge = (high - low) / cells;
  vec3 ahead = mix(forward, vec3(1e-6), lessThan(abs(forward), vec3(1e-6)));
  vec3 a = (low - start) / ahead, b = (high - start) / ahead;
  float enter = max(max(min(a.x, b.x), min(a.y, b.y)), min(a.z, b.z));
  float leave = min(min(max(a.x, b.x), max(a.y, b.y)), max(a.z, b.z));

  vec3 speed = ahead / edge, quick = abs(speed);
  vec3 axis = quick.x >= quick.y && quick.x >= quick.z ? vec3(1, 0, 0) : quick.y >= quick.z ? vec3(0, 1, 0) : vec3(0, 0, 1);
  float rate = dot(speed, axis), plane = dot((start - low) / edge - 0.5, axis);
  float from = plane + rate * enter, to = plane + rate * leave;
  float way = sign(rate), first = way > 0.0 ? ceil(from) : floor(from);
  int planes = enter < leave ? int(floor((to - first) * way)) + 1 : 0;

  float spacing = 1.0 / abs(rate), sum = 0.0, clear = 1.0;
  vec3 place = ((start - low) + ahead * ((first - plane) / rate)) / (high - low);
  vec3 stride = ahead * spacing / (high - low);
  float nearest, before = -1.0, open = 1.0;  // the sum before a solid, and what it lets through
  vec4 solid = stand(nearest);
  float away = (first - plane) / rate;
  for (int i = 0; i < planes; ++i, away += spacing) {
    float light = texture(density, place.yzx).r * peak * spacing;
    float depth = light * absorption / 255.0;
    if (lamps.x > 0.0) {
      vec2 reaching = texture(shade, place.xzy).rg;
      light = depth * 255.0 * (lamps.x * (reaching.r + reaching.g / 255.0) + lamps.y);
    }
    float part = clamp((nearest - away) / spacing + 0.5, 0.0, 1.0);
    if (part < 1.0 && before < 0.0) {
      before = sum + clear * light * part * passing(depth * part);
      open = clear * exp(-depth * part);
    }
    sum += clear * light * passing(depth);
    clear *= exp(-depth);
    if (clear < 1e-3) break;
    place += stride;
  }
  if (before < 0.0) before = sum, open = clear;
  vec3 past = look(sum, clear) + clear * background, front = look(before, open) + open * solid.rgb;
  colour = vec4(mix(past, front, solid.a), 1.0);
}
