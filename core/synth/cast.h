// The people of the demo: six looks, each a shape, a complexion, hair and clothes. Colours are linear albedo.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/base/linalg.h"

namespace likeness {

struct SkinLook {
  Vec3f complexion = Vec3f(0.565f, 0.335f, 0.235f);
  Vec3f lips = Vec3f(0.375f, 0.145f, 0.122f);
  Vec3f brows = Vec3f(0.034f, 0.017f, 0.009f);
  Vec3f iris_inner = Vec3f(0.115f, 0.070f, 0.028f), iris_outer = Vec3f(0.040f, 0.072f, 0.078f);
  float blood = 1;       // how much redder cheeks, nose and ears are
  float freckles = 1;    // 0 none
  float stubble = 1;     // shadow of a shaved beard
  float brow_width = 1;  // of the hairs across the brow
  float wrinkles = 0;    // 0 smooth .. 1 deep lines
  float lash = 1;        // darkness of the lid margins
  float gloss = 0;       // 0 usual .. 1 shiny
};

enum class HairCut { swept, cropped, receding, bob, shoulder_long, loose };

struct HairLook {
  HairCut cut = HairCut::swept;
  Vec3f colour = Vec3f(0.115f, 0.062f, 0.033f);
  float grey = 0;   // share of white strands
  float curl = 0;   // 0 straight .. 1 tight
  float beard = 0;  // length of the beard over the chin, m; 0 none
  Vec3f beard_colour = Vec3f(0.115f, 0.062f, 0.033f);
};

struct ClothLook {
  Vec3f ground = Vec3f(0.060f, 0.105f, 0.185f);
  std::array<Vec3f, 3> inks{Vec3f(0.62f, 0.55f, 0.43f), Vec3f(0.42f, 0.12f, 0.05f),
                            Vec3f(0.13f, 0.20f, 0.09f)};
  bool patterned = true;
};

struct GlassesLook {
  bool worn = false;
  bool round = false;
  float thickness = 0.0016f;  // radius of the rim, m
  Vec3f colour = Vec3f(0.02f, 0.018f, 0.016f);
};

struct DemoPerson {
  std::string name, description;
  SkinLook skin;
  HairLook hair;
  ClothLook cloth;
  GlassesLook glasses;
  // Directions of the built-in head by name, standard deviations; the random part drawn by `--seed` is added,
  // times `scatter`.
  std::vector<std::pair<std::string, float>> identity;
  float scatter = 0.25f;
  float lopsided = 1;  // sign and strength of the face's asymmetric expressions
};

// Always six, beginning with the default person.
const std::vector<DemoPerson>& demo_people();
// The person of that number, or the default one.
const DemoPerson& demo_person(int number);

// Names of the three lights: a soft window, the room's ceiling light, a lamp in the evening.
const std::vector<std::string>& demo_lights();

}  // namespace likeness
