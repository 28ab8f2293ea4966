// Maps and detector on the same pictures: see landmark_study.h.
#include "core/lab/study/landmark_study.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/face/landmarks.h"
#include "core/head/pose_head.h"
#include "core/image/files.h"
#include "core/lab/score/held_out.h"
#include "core/project/project_attributes.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/training_set.h"
#include "core/render/pose_avatar.h"
#include "core/train/landmark_patches.h"

namespace likeness {
namespace {

constexpr int kShifts = 6;
constexpr double kShortest = 0.02, kLongest = 0.04;  // of the shifts, interocular distances

// The picture's content moved by `shift` px; the border is continued.
Image8 moved_by(const Image8& picture, const Vec2d& shift) {
  Image8 out(picture.width, picture.height, picture.channels);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const double fx = std::clamp(x - shift.x(), 0.0, out.width - 1.001),
                   fy = std::clamp(y - shift.y(), 0.0, out.height - 1.001);
      const int ix = int(fx), iy = int(fy);
      const double ax = fx - ix, ay = fy - iy;
      for (int c = 0; c < out.channels; ++c) {
        const double above = (1 - ax) * picture.at(ix, iy)[c] + ax * picture.at(ix + 1, iy)[c];
        const double below = (1 - ax) * picture.at(ix, iy + 1)[c] + ax * picture.at(ix + 1, iy + 1)[c];
        out.at(x, y)[c] = std::uint8_t(std::lround((1 - ay) * above + ay * below));
      }
    }
  return out;
}

// Landmarks in one frame's picture and in pictures compared with it, all from the box of the true face.
class FrameDetector {
 public:
  FrameDetector(const FaceDetector& detector, const Image8& truth) : detector_(detector) {
    scale_ = truth.width < 512 ? 512 / truth.width : 1;  // the detector needs faces of 80 px or more
    const auto faces = detector.detect(enlarged(truth));
    if (!faces.empty()) box_ = faces.front();
  }
  bool has_face() const { return box_.width > 0; }
  std::array<Vec2d, kLandmarkCount> points(const Image8& picture) const {
    auto points = detector_.landmarks(enlarged(picture), box_).points;
    for (Vec2d& point : points) point /= scale_;
    return points;
  }

 private:
  Image8 enlarged(const Image8& picture) const {
    return resize(picture, picture.width * scale_, picture.height * scale_);
  }
  const FaceDetector& detector_;
  FaceBox box_;
  int scale_ = 1;
};

// A landmark's offset in some picture against the truth, interocular distances.
struct Offset {
  Vec2d by_map, by_dlib;
};

OffsetAgreement agreement(const Vec2d& one, const Vec2d& other) {
  return {one.dot(other), one.squaredNorm(), other.squaredNorm()};
}

// Adds one frame to the rows; false if no face is found in it. places: in its true picture.
bool compare_frame(const LandmarkPatches& patches, std::span<const PatchPlace> places,
                   const FaceDetector& detector, const Image8& truth, const Image8& render,
                   std::vector<LandmarkRow>& rows) {
  const FrameDetector in_frame(detector, truth);
  if (!in_frame.has_face()) return false;
  const auto true_points = in_frame.points(truth);
  const auto offsets_in = [&](const Image8& picture) {
    const auto points = in_frame.points(picture);
    std::vector<Offset> offsets;
    for (const PatchPlace& place : places) {
      const std::size_t k = std::size_t(place.landmark);
      const LandmarkMap& map = patches.maps[k];
      offsets.push_back(
          {map.map.empty()
               ? Vec2d::Zero().eval()
               : Vec2d(landmark_offset(map, place, patches.stride, picture, truth).cast<double>()),
           (points[k] - true_points[k]) / patches.interocular_px});
    }
    return offsets;
  };
  const auto row_of = [&](std::size_t i) {
    return std::ranges::find(rows, places[i].landmark, &LandmarkRow::landmark);
  };
  const std::vector<Offset> in_render = offsets_in(render);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (const auto row = row_of(i); row != rows.end())
      row->render.add(agreement(in_render[i].by_map, in_render[i].by_dlib));
  for (int s = 0; s < kShifts; ++s) {
    const double angle = 2 * std::numbers::pi * s / kShifts;
    const Vec2d shift = (s % 2 == 0 ? kShortest : kLongest) * Vec2d(std::cos(angle), std::sin(angle));
    const Vec2d px = shift * patches.interocular_px;
    const std::vector<Offset> of_truth = offsets_in(moved_by(truth, px)),
                              of_render = offsets_in(moved_by(render, px));
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto row = row_of(i);
      if (row == rows.end()) continue;
      row->truth.add(agreement(of_truth[i].by_map, of_truth[i].by_dlib));
      row->truth_map.add(agreement(of_truth[i].by_map, shift));
      row->truth_dlib.add(agreement(of_truth[i].by_dlib, shift));
      row->shifted.add(agreement(of_render[i].by_map, of_render[i].by_dlib));
      row->shifted_map.add(agreement(of_render[i].by_map - in_render[i].by_map, shift));
    }
  }
  return true;
}

}  // namespace

void OffsetAgreement::add(const OffsetAgreement& more) {
  both += more.both, one += more.one, other += more.other;
}
double OffsetAgreement::correlation() const { return both / std::sqrt(one * other); }

Result<LandmarkStudy> study_landmarks(const Project& project, int frames, const Progress& progress,
                                      std::stop_token stop) {
  const auto set = read_held_out(project);
  if (!set) return set.error();
  const auto model = project_head_model(project.options);
  if (!model) return model.error();
  const auto training = load_training_set(project, *model);
  if (!training) return training.error();
  const auto detector = FaceDetector::load(project.options.shared.landmark_model);
  if (!detector) return detector.error();
  progress.report(0, "learning the patches");
  const auto patches =
      learn_landmark_patches(*training, shape_head(training->model, training->person), set->avatar.seed);
  if (!patches) return patches.error();

  LandmarkStudy study;
  study.stride = patches->stride, study.interocular_px = patches->interocular_px;
  for (int k = 0; k < kLandmarkCount; ++k)
    if (const LandmarkMap& map = patches->maps[std::size_t(k)]; !map.map.empty())
      study.rows.push_back({k, map.correlation, map.spread, map.weight > 0, {}, {}, {}, {}, {}, {}});

  const auto made = make_rig(set->avatar, *model);
  if (!made) return made.error();
  const AvatarRig& rig = *made;
  const auto courses = read_courses(project, set->avatar);
  if (!courses) return courses.error();
  const auto held_out = held_out_frames(set->capture);
  const std::vector<int> all(held_out.begin(), held_out.end());
  const std::size_t count = frames > 0 ? std::min(all.size(), std::size_t(frames)) : all.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (stop.stop_requested()) return cancelled_error();
    const int frame = all[i * all.size() / count];
    progress.report(double(i) / double(count), fmt::format("frame {}", frame));
    const TrackedFrame* t = find_tracked(set->track, frame);
    const auto camera = picture_camera(set->capture, set->cameras, set->track, frame);
    if (!t || t->status == FrameStatus::lost || !camera) continue;
    const auto truth =
        read_own_picture(project.folder / "frames", fmt::format("{:06}.png", frame), set->capture.size, 3);
    if (!truth) return truth.error();
    const RenderState state = pose_avatar(rig, frame_pose(set->avatar, *courses, *t));
    const RenderedFrame rendered =
        render_frame(set->avatar, *camera, state, render_options(RenderQuality::final));
    const Image8 picture = to_bytes(composite(rendered.rgba, plate_behind(*set, frame, *camera)));
    const TrainingView view{.camera = *camera, .pose = t->pose, .rgb = *truth};
    study.frames += compare_frame(*patches, patch_places(*model, rig.shape, view, patches->stride), *detector,
                                  *truth, picture, study.rows);
  }
  if (study.frames == 0)
    return Error{
        ErrorCode::failed,
        "In none of the held-out frames is there a track and a face to be found, so nothing can be measured.",
        "Film a longer clip in which the face stays in view to the end.", project.folder.string()};
  progress.report(1);
  return study;
}

}  // namespace likeness
