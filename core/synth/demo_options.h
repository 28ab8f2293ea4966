// What is asked of the demo: how it is filmed, who is in it and in which light.
#pragma once

namespace likeness {

struct DemoOptions {
  int width = 512, height = 512;
  int frames = 240;
  double frames_per_second = 25;
  double moving_share = 0.35;  // of the frames, with the camera moving; 0 = static camera throughout
  bool restless_head = false;  // the head already turns while the camera moves, as people are asked not to do
  int samples_per_pixel = 4;
  int person = 0;  // 0..5, see core/synth/cast.h
  int light = 0;   // 0..2: soft window, ceiling light, lamp in the evening
  int seed = 0;
  bool habit =
      false;  // now and then one cheek is puffed, independent of the expression (PersonalPlay::habit)
};

}  // namespace likeness
