#version 300 es
// Puts a body where it is in a frame, and that into the picture.
uniform mat4x3 pose;              // to places from the middle of the box (x, y, z) [voxel of the run]
uniform vec3 right, up, forward;
uniform vec2 middle, scale;       // of the picture, which spans -1 to 1
uniform float reach;              // depth [voxel] that spans -1 to 1
layout(location = 0) in vec3 vertex;
layout(location = 1) in vec3 normal;
out vec3 place, outward;

void main() {
  mat3 turn = mat3(pose);
  place = turn * vertex + pose[3];
  outward = normal.x * cross(turn[1], turn[2]) + normal.y * cross(turn[2], turn[0]) + normal.z * cross(turn[0], turn[1]);
  vec2 at = middle + scale * vec2(dot(place, right), dot(place, up));
  gl_Position = vec4(at, dot(place, forward) / reach, 1.0);
}
