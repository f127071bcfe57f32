#version 300 es
// A matt surface in light from one side, which the medium may weaken on its way, and from all around.
precision highp float;
precision highp sampler3D;

uniform vec3 color, toLight;
uniform vec2 lamps;          // light from one side, and from all around
uniform bool shaded;
uniform sampler3D shade;     // as for the volume
uniform vec3 low, high;      // corners of what is stored
in vec3 place, outward;
out vec4 seen;

float reaching() { // where the way to the light enters the volume
  vec3 a = (low - place) / toLight, b = (high - place) / toLight;
  float enter = max(max(max(min(a.x, b.x), min(a.y, b.y)), min(a.z, b.z)), 0.0);
  float leave = min(min(max(a.x, b.x), max(a.y, b.y)), max(a.z, b.z));
  if (enter >= leave) return 1.0;
  vec2 bytes = texture(shade, ((place + enter * toLight - low) / (high - low)).xzy).rg;
  return bytes.r + bytes.g / 255.0;
}

void main() {
  float facing = max(dot(normalize(outward), normalize(toLight)), 0.0);
  if (shaded && facing > 0.0) facing *= reaching();
  seen = vec4(min(color * (lamps.x * facing + lamps.y), 1.0), 1.0);
}
