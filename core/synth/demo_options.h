// What is asked of the demo: how it is filmed, who is in it and in which light.
#pragma once

namespace likeness {

enum class DemoCamera {
  guided,    // as people are asked to film: it moves first, then it rests (DemoOptions::moving_share)
  resting,   // one camera from the first frame to the last
  handheld,  // held before the person: it sways and shakes, and the focal length breathes
  walking,   // goes from side to side through the whole clip
  zoom,      // handheld, and it zooms in and out
  slide      // resting, but of its wide picture a crop is kept that follows the face
};
enum class DemoHair {
  own,   // as the person wears it
  loose  // long, falling before and behind the shoulders
};
enum class DemoWall {
  furnished,  // the room
  plain,      // a wall without any texture fills the background
  textured    // the same wall with plaster on it
};

// How far the head turns at most in the whole performance: 30 degrees to the side with 12 up or down, a tilt
// and the torso's sway.
inline constexpr double kWidestTurn_deg = 34.8;

struct DemoOptions {
  int width = 512, height = 512;
  int frames = 240;
  double frames_per_second = 25;
  double moving_share = 0.35;  // guided: of the frames, with the camera moving; 0 = static throughout
  bool restless_head = false;  // the head already turns while the camera moves, as people are asked not to do
  int samples_per_pixel = 4;
  int person = 0;  // 0..5, see core/synth/cast.h
  int light = 0;   // 0..2: soft window, ceiling light, lamp in the evening
  int seed = 0;
  bool habit =
      false;  // now and then one cheek is puffed, independent of the expression (PersonalPlay::habit)
  // A performance that leaves out what an avatar is later asked for (core/lab/beyond).
  double head_within_deg = kWidestTurn_deg;  // the head turns at most this far from its rest, > 0
  double action_share = 1;                   // of each action of the face, lids included, (0, 1]

  // The faults of films that people have already, instead of those that they are asked to make.
  DemoCamera camera = DemoCamera::guided;
  double hand_turn_deg = 3;      // handheld, zoom: the camera turns by at most this, 0..10
  double hand_shift_m = 0.0015;  // and is displaced by at most this, 0..0.05; 0: it turns about its lens
  int cuts = 0;                  // hard cuts (core/synth/demo_shots.h)
  DemoHair hair = DemoHair::own;
  DemoWall wall = DemoWall::furnished;
  bool still_torso = false;  // the torso does not move at all
  bool drift = false;        // exposure, white balance and focus wander (core/synth/drift.h)
  bool motion_blur = false;  // of what moves quickly; several times as slow there
  bool lens_tag = false;     // the film says its focal length, as phones do
};

}  // namespace likeness
