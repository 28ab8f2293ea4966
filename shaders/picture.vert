// A rectangle over the whole target, from the vertex number alone.
#version 330 core
out vec2 place;  // [0, 1], origin top left of the picture

void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  place = corner;  // the target's first row is the picture's top, as in uploaded textures
  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
