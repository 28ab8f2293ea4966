// A rendered picture (premultiplied, sRGB-encoded) enlarged by Catmull-Rom splines, laid over its background,
// exposed and rolled off.
#version 330 core
in vec2 place;
out vec4 colour;

uniform sampler2D picture;      // premultiplied alpha
uniform sampler2D background;   // opaque
uniform float background_share; // 0: plain only; 1: the background's picture
uniform vec3 background_place;  // scale, shift x, shift y: where the background's picture lies
uniform vec4 plain;             // colour behind it; alpha 0: a chequered ground
uniform float doubt;            // of the picture: fades it into the ground, at most by a half
uniform float exposure;         // factor on linear light

// The picture at p texels by Catmull-Rom splines, kept within the four neighbours: no ringing.
vec4 enlarged(vec2 p) {
  ivec2 last = textureSize(picture, 0) - 1;
  vec2 corner = floor(p - 0.5), f = p - 0.5 - corner;
  vec4 low = vec4(1e9), high = vec4(-1e9), sum = vec4(0.0);
  vec2 w[4];
  w[0] = f * (-0.5 + f * (1.0 - 0.5 * f));
  w[1] = 1.0 + f * f * (-2.5 + 1.5 * f);
  w[2] = f * (0.5 + f * (2.0 - 1.5 * f));
  w[3] = f * f * (-0.5 + 0.5 * f);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      vec4 t = texelFetch(picture, clamp(ivec2(corner) + ivec2(x - 1, y - 1), ivec2(0), last), 0);
      sum += w[x].x * w[y].y * t;
      if ((x == 1 || x == 2) && (y == 1 || y == 2)) low = min(low, t), high = max(high, t);
    }
  return clamp(sum, low, high);
}

vec3 to_linear(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
vec3 to_encoded(vec3 c) {
  return mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

// Straight up to a shoulder, then bending towards 1: highlights of a raised exposure keep their drawing.
vec3 rolled_off(vec3 c) {
  const float shoulder = 0.8;
  vec3 over = max(c - shoulder, 0.0) / (1.0 - shoulder);
  return min(c, shoulder) + (1.0 - shoulder) * over / (1.0 + over);
}

void main() {
  vec4 front = enlarged(place * vec2(textureSize(picture, 0)));
  float tile = mod(floor(gl_FragCoord.x / 12.0) + floor(gl_FragCoord.y / 12.0), 2.0);
  vec3 ground = plain.a > 0.0 ? plain.rgb : vec3(0.42 + 0.1 * tile);
  vec2 there = (place - 0.5 - background_place.yz) / background_place.x + 0.5;
  bool inside = all(greaterThanEqual(there, vec2(0.0))) && all(lessThanEqual(there, vec2(1.0)));
  vec3 behind = mix(ground, texture(background, there).rgb, inside ? background_share : 0.0);
  // What nobody saw loses its colour first, then a part of its presence.
  const float most_faded = 0.55;
  float grey = dot(front.rgb, vec3(0.2126, 0.7152, 0.0722));
  front.rgb = mix(front.rgb, vec3(grey), 0.8 * doubt);
  front *= 1.0 - most_faded * doubt;
  vec3 shown = front.rgb + (1.0 - front.a) * behind;
  if (exposure != 1.0) shown = to_encoded(rolled_off(to_linear(clamp(shown, 0.0, 1.0)) * exposure));
  colour = vec4(shown, 1.0);
}
