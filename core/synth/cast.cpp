// The people of the demo.
#include "core/synth/cast.h"

namespace likeness {
namespace {

DemoPerson default_person() {
  DemoPerson p;
  p.name = "Alex";
  p.description = "man of 35, light tan skin, stubble, short brown hair";
  p.scatter = 0.6f;
  return p;
}

DemoPerson dark_woman() {
  DemoPerson p;
  p.name = "Amara";
  p.description = "woman of 28, very dark skin, cropped black curls";
  SkinLook& s = p.skin;
  s.complexion = Vec3f(0.122f, 0.062f, 0.038f);
  s.lips = Vec3f(0.150f, 0.058f, 0.050f);
  s.brows = Vec3f(0.010f, 0.007f, 0.006f);
  s.iris_inner = Vec3f(0.040f, 0.018f, 0.008f);
  s.iris_outer = Vec3f(0.022f, 0.011f, 0.007f);
  s.blood = 0.55f, s.freckles = 0.15f, s.stubble = 0, s.lash = 1.25f, s.gloss = 0.1f;
  p.hair.cut = HairCut::cropped;
  p.hair.colour = Vec3f(0.020f, 0.014f, 0.011f);
  p.hair.curl = 1;
  p.cloth.ground = Vec3f(0.50f, 0.27f, 0.045f);
  p.cloth.inks = {Vec3f(0.05f, 0.04f, 0.035f), Vec3f(0.55f, 0.10f, 0.04f), Vec3f(0.66f, 0.60f, 0.50f)};
  p.identity = {{"jaw_width", -1.0f},    {"chin_length", -0.6f},     {"nose_width", 1.5f},
                {"nose_bridge", -1.1f},  {"nose_protrusion", -0.5f}, {"lip_thickness", 1.8f},
                {"mouth_width", 0.6f},   {"mouth_protrusion", 0.9f}, {"cheekbones", 0.9f},
                {"brow_ridge", -1.4f},   {"eye_opening", 0.8f},      {"eye_width", 0.5f},
                {"skull_back", 0.8f},    {"forehead_slope", -0.7f},  {"size", -0.6f},
                {"neck_width", -1.3f},   {"brow_height", 0.6f},      {"ear_size", -1.0f},
                {"temple_width", -0.4f}, {"cheek_fullness", 0.5f}};
  p.lopsided = -0.9f;
  return p;
}

DemoPerson bearded_man() {
  DemoPerson p;
  p.name = "Erik";
  p.description = "man of 40, pale freckled skin, ginger hair and full short beard";
  SkinLook& s = p.skin;
  s.complexion = Vec3f(0.690f, 0.465f, 0.365f);
  s.lips = Vec3f(0.480f, 0.200f, 0.170f);
  s.brows = Vec3f(0.140f, 0.060f, 0.022f);
  s.iris_inner = Vec3f(0.130f, 0.140f, 0.110f);
  s.iris_outer = Vec3f(0.075f, 0.135f, 0.185f);
  s.blood = 1.25f, s.freckles = 1.7f, s.stubble = 0.5f, s.brow_width = 1.15f, s.wrinkles = 0.30f,
  s.lash = 0.7f;
  p.hair.cut = HairCut::swept;
  p.hair.colour = Vec3f(0.300f, 0.120f, 0.042f);
  p.hair.beard = 0.012f;
  p.hair.beard_colour = Vec3f(0.310f, 0.115f, 0.038f);
  p.cloth.ground = Vec3f(0.085f, 0.120f, 0.075f);
  p.cloth.inks = {Vec3f(0.55f, 0.52f, 0.44f), Vec3f(0.30f, 0.16f, 0.06f), Vec3f(0.03f, 0.05f, 0.04f)};
  p.identity = {{"size", 0.7f},
                {"jaw_width", 1.2f},
                {"chin_protrusion", 0.7f},
                {"chin_width", 0.9f},
                {"brow_ridge", 1.1f},
                {"nose_length", 0.7f},
                {"nose_protrusion", 0.8f},
                {"nose_width", 0.3f},
                {"lip_thickness", -0.9f},
                {"eye_depth", 0.9f},
                {"eye_opening", -0.5f},
                {"lower_face_length", 0.6f},
                {"neck_width", 1.1f},
                {"cheek_fullness", -0.3f},
                {"ear_size", 0.6f},
                {"brow_height", -0.6f}};
  p.lopsided = 1.1f;
  return p;
}

DemoPerson long_haired_woman() {
  DemoPerson p;
  p.name = "Lin";
  p.description = "woman of 30, light warm skin, long black hair over ears and shoulders";
  SkinLook& s = p.skin;
  s.complexion = Vec3f(0.600f, 0.405f, 0.275f);
  s.lips = Vec3f(0.460f, 0.140f, 0.130f);
  s.brows = Vec3f(0.022f, 0.014f, 0.010f);
  s.iris_inner = Vec3f(0.052f, 0.026f, 0.011f);
  s.iris_outer = Vec3f(0.026f, 0.014f, 0.008f);
  s.blood = 0.7f, s.freckles = 0.2f, s.stubble = 0, s.brow_width = 0.8f, s.lash = 1.35f, s.gloss = 0.25f;
  p.hair.cut = HairCut::shoulder_long;
  p.hair.colour = Vec3f(0.032f, 0.022f, 0.017f);
  p.cloth.ground = Vec3f(0.52f, 0.44f, 0.40f);
  p.cloth.inks = {Vec3f(0.33f, 0.07f, 0.08f), Vec3f(0.10f, 0.13f, 0.21f), Vec3f(0.68f, 0.64f, 0.58f)};
  p.identity = {{"face_flatness", -0.9f}, {"nose_bridge", -1.1f}, {"nose_protrusion", -0.7f},
                {"nose_length", -0.5f},   {"nose_width", 0.2f},   {"jaw_width", -0.8f},
                {"chin_length", -0.5f},   {"chin_width", -0.7f},  {"cheekbones", 0.8f},
                {"cheek_fullness", 0.5f}, {"brow_ridge", -1.5f},  {"eye_tilt", 1.1f},
                {"eye_opening", -0.5f},   {"eye_depth", -0.8f},   {"lip_thickness", 0.4f},
                {"mouth_width", -0.4f},   {"size", -0.8f},        {"neck_width", -1.4f},
                {"width", 0.4f},          {"ear_size", -0.7f}};
  p.lopsided = -1.0f;
  return p;
}

DemoPerson old_woman() {
  DemoPerson p;
  p.name = "Ruth";
  p.description = "woman of 70, fair lined skin, white bob, dark-rimmed glasses";
  SkinLook& s = p.skin;
  s.complexion = Vec3f(0.630f, 0.415f, 0.325f);
  s.lips = Vec3f(0.410f, 0.185f, 0.165f);
  s.brows = Vec3f(0.200f, 0.170f, 0.145f);
  s.iris_inner = Vec3f(0.090f, 0.095f, 0.080f);
  s.iris_outer = Vec3f(0.070f, 0.100f, 0.115f);
  s.blood = 1.1f, s.freckles = 0.8f, s.stubble = 0, s.brow_width = 0.75f, s.wrinkles = 1, s.lash = 0.55f;
  p.hair.cut = HairCut::bob;
  p.hair.colour = Vec3f(0.420f, 0.390f, 0.355f);
  p.hair.grey = 0.5f;
  p.cloth.ground = Vec3f(0.200f, 0.065f, 0.110f);
  p.cloth.inks = {Vec3f(0.58f, 0.50f, 0.50f), Vec3f(0.10f, 0.05f, 0.13f), Vec3f(0.42f, 0.18f, 0.22f)};
  p.glasses = {true, false, 0.0016f, Vec3f(0.035f, 0.012f, 0.010f)};
  p.identity = {
      {"jowls", 1.5f},        {"cheek_fullness", -0.8f}, {"lip_thickness", -1.3f},  {"nose_length", 0.9f},
      {"nose_width", 0.4f},   {"eye_opening", -0.6f},    {"eye_depth", 0.6f},       {"brow_ridge", -0.8f},
      {"brow_height", -0.5f}, {"jaw_width", -0.2f},      {"ear_size", 1.0f},        {"size", -0.7f},
      {"neck_width", -0.8f},  {"mouth_height", -0.3f},   {"chin_protrusion", 0.5f}, {"brow_tilt", -0.8f}};
  p.lopsided = 0.8f;
  return p;
}

DemoPerson brown_man() {
  DemoPerson p;
  p.name = "Samir";
  p.description = "man of 55, brown skin, receding greying hair, grey short beard, thin round glasses";
  SkinLook& s = p.skin;
  s.complexion = Vec3f(0.300f, 0.165f, 0.098f);
  s.lips = Vec3f(0.240f, 0.098f, 0.080f);
  s.brows = Vec3f(0.020f, 0.015f, 0.013f);
  s.iris_inner = Vec3f(0.070f, 0.034f, 0.013f);
  s.iris_outer = Vec3f(0.034f, 0.018f, 0.009f);
  s.blood = 0.75f, s.freckles = 0.3f, s.stubble = 1, s.brow_width = 1.35f, s.wrinkles = 0.65f,
  s.gloss = 0.15f;
  p.hair.cut = HairCut::receding;
  p.hair.colour = Vec3f(0.040f, 0.032f, 0.028f);
  p.hair.grey = 0.32f;
  p.hair.beard = 0.0065f;
  p.hair.beard_colour = Vec3f(0.130f, 0.120f, 0.110f);
  p.cloth.ground = Vec3f(0.150f, 0.145f, 0.140f);
  p.cloth.patterned = false;
  p.glasses = {true, true, 0.0010f, Vec3f(0.20f, 0.16f, 0.10f)};
  p.identity = {{"width", 0.6f},           {"cheek_fullness", 1.0f}, {"jowls", 0.7f},
                {"nose_protrusion", 1.2f}, {"nose_bridge", 0.9f},    {"nose_length", 0.8f},
                {"nose_tip_up", -0.9f},    {"brow_ridge", 0.8f},     {"eye_depth", 0.7f},
                {"lip_thickness", 0.4f},   {"jaw_width", 0.4f},      {"neck_width", 1.0f},
                {"eye_tilt", -0.6f},       {"ear_size", 0.8f},       {"forehead_slope", 0.6f}};
  p.lopsided = 0.95f;
  return p;
}

}  // namespace

const std::vector<DemoPerson>& demo_people() {
  static const std::vector<DemoPerson> people = {default_person(),    dark_woman(), bearded_man(),
                                                 long_haired_woman(), old_woman(),  brown_man()};
  return people;
}

const DemoPerson& demo_person(int number) {
  const auto& people = demo_people();
  return number >= 0 && number < int(people.size()) ? people[std::size_t(number)] : people.front();
}

const std::vector<std::string>& demo_lights() {
  static const std::vector<std::string> lights = {"soft window from the side", "ceiling light",
                                                  "lamp in the evening"};
  return lights;
}

}  // namespace likeness
