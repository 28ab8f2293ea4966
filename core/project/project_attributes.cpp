// See project_attributes.h.
#include "core/project/project_attributes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <system_error>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "core/base/parallel.h"
#include "core/base/rigid.h"
#include "core/image/files.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/train/attribute_values.h"
#include "core/train/capture_summary.h"
#include "core/train/condition_map.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

constexpr float kShown = 0.2f;  // of the larger end of what was seen

// The frames whose amounts are found: the training's views, then the held-out frames.
struct Frames {
  std::vector<TrainingView> held_out;  // with their pictures
  std::vector<const TrainingView*> all;
  Capture capture;
};

Result<Frames> gather_frames(const Project& project, const TrainingSet& set, std::stop_token stop) {
  auto read = read_tracked_capture(project);
  if (!read) return read.error();
  Frames frames;
  frames.capture = read->capture;
  for (CaptureFrame& frame : read->capture.frames) frame.used = frame.held_out;
  frames.held_out = tracked_views(*read);
  for (TrainingView& view : frames.held_out) {
    if (stop.stop_requested()) return cancelled_error();
    auto rgb =
        read_own_picture(project.folder / "frames", fmt::format("{:06}.png", view.camera.frame), set.size, 3);
    if (!rgb) return rgb.error();
    view.rgb = std::move(*rgb);
  }
  for (const TrainingView& view : set.views) frames.all.push_back(&view);
  for (const TrainingView& view : frames.held_out) frames.all.push_back(&view);
  return frames;
}

// What changes the look of a region besides the attribute: how the head is turned to the camera, and the
// expression.
std::vector<Eigen::VectorXf> asides_of(const Frames& frames, const TrainingSet& set, const HeadShape& shape) {
  std::vector<Articulation> learnt;
  for (const TrainingView& view : own_views(set)) learnt.push_back(view.pose.articulation);
  const ConditionMap map = learn_condition_map(set.model, shape, learnt);
  std::vector<Eigen::VectorXf> asides;
  for (const TrainingView* view : frames.all) {
    const Eigen::AngleAxisd turn =
        axis_and_angle((view->camera.cam_from_world * view->pose.world_from_head).linear());
    const Mat3d r = rotation_about(turn.axis(), turn.angle());
    const Eigen::VectorXf psi = condition(map, view->pose.articulation);
    Eigen::VectorXf aside(6 + psi.size());
    const float x = float(r(0, 2)), y = float(r(1, 2));  // where the face looks
    aside[0] = x, aside[1] = y, aside[2] = float(r(0, 1));
    aside[3] = x * x, aside[4] = y * y, aside[5] = x * y;
    aside.tail(psi.size()) = psi;
    asides.push_back(std::move(aside));
  }
  return asides;
}

Error too_little(const PaintedAttribute& attribute, const std::string& what) {
  return {ErrorCode::bad_input, fmt::format("The attribute '{}' cannot be learnt: {}.", attribute.name, what),
          fmt::format("Paint it on more training frames, some that show it and some that do not, or take it "
                      "out: likeness attribute remove PROJECT \"{}\"",
                      attribute.name),
          "attributes.json"};
}

struct Annotated {
  std::size_t frame;  // index into Frames::all
  const AttributeAnnotation* annotation;
};

// The annotations of the project's own training frames.
std::vector<Annotated> annotated_frames(const PaintedAttribute& attribute, const TrainingSet& set) {
  std::vector<Annotated> annotated;
  const auto own = own_views(set);
  for (const AttributeAnnotation& annotation : attribute.annotations)
    for (std::size_t v = 0; v < own.size(); ++v)
      if (own[v].camera.frame == annotation.frame) annotated.push_back({v, &annotation});
  return annotated;
}

Result<FoundAttribute> find_attribute(const PaintedAttribute& attribute, const TrainingSet& set,
                                      const Frames& frames, const HeadShape& shape,
                                      const std::vector<Eigen::VectorXf>& asides, std::span<const Vec3f> rest,
                                      const RegionOptions& region) {
  const std::vector<Annotated> annotated = annotated_frames(attribute, set);
  const auto value = [](const Annotated& a) { return a.annotation->value; };
  if (annotated.size() < 2)
    return too_little(attribute, fmt::format("{} of its frames train", annotated.size()));
  const auto [least, most] = std::ranges::minmax(annotated, {}, value);
  if (value(most) - value(least) < 0.05)
    return too_little(attribute, fmt::format("all its frames show {:.2f} of it", value(most)));

  // -- The region
  std::vector<float> paint(rest.size(), 0.f);
  for (const auto& [v, annotation] : annotated) {
    if (annotation->region.empty()) continue;
    const TrainingView& view = *frames.all[v];
    const StrokeCover cover = cover_strokes(annotation->region, frames.capture.crop, set.size);
    if (cover.empty()) continue;
    const auto carried = carry_paint(set.model, pose_head(set.model, shape, view.pose.articulation),
                                     view.camera, view.pose.world_from_head, cover.person);
    for (std::size_t i = 0; i < paint.size(); ++i) paint[i] = std::max(paint[i], carried[i]);
  }
  const std::vector<float> distance = distance_to_paint(rest, paint),
                           weights = soft_weights(distance, region);
  const LookPoints points = look_points(set.model, distance);
  if (points.region.empty() || points.around.empty())
    return too_little(attribute, "what was painted covers no part of the head, or all of it");
  FoundAttribute found;
  found.region = make_region(attribute.name, set.model, rest, weights, region);

  // -- The amounts
  std::vector<LookedFrame> looked(frames.all.size());
  parallel_for(looked.size(), [&](std::size_t i) {
    const TrainingView& view = *frames.all[i];
    LookedFrame& frame = looked[i];
    frame.look = region_look(set.model, pose_head(set.model, shape, view.pose.articulation), view.camera,
                             view.pose.world_from_head, view.rgb, points);
    frame.aside = asides[i];
    frame.training = i < set.views.size();
    frame.time_s = time_of_frame(frames.capture, view.camera.frame);
    frame.run = frame.training ? view.further_clip : -1;
  });
  for (const auto& [v, annotation] : annotated)
    looked[v].annotated = true, looked[v].value = annotation->value;
  if (!can_regress(looked))
    return too_little(attribute, "too few of its frames show the region and the skin around it well");
  const AmountFit fit = regress_amounts(looked);

  // -- What was found, frame by frame
  AttributeCourse& course = found.course;
  course.name = attribute.name;
  course.painted_frames = int(annotated.size());
  course.skipped_frames = int(attribute.annotations.size() - annotated.size());
  course.left_out_error = fit.left_out_error;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < looked.size(); ++i)
    if (frames.all[i]->further_clip == 0) order.push_back(i);
  std::ranges::sort(order, {}, [&](std::size_t i) { return frames.all[i]->camera.frame; });
  for (const std::size_t i : order) {
    course.frames.push_back(frames.all[i]->camera.frame);
    course.values.push_back(fit.frames[i].value), course.doubts.push_back(fit.frames[i].uncertainty);
    course.annotated.push_back(looked[i].annotated);
    course.unlike_any += fit.frames[i].uncertainty > kUnlikeAny;
  }
  for (std::size_t v = 0; v < set.views.size(); ++v) found.view_values.push_back(fit.frames[v].value);
  const auto [low, high] = std::ranges::minmax(found.view_values);
  found.region.low = std::min(0.f, low), found.region.high = std::max(0.f, high);
  const float full = std::max(-found.region.low, found.region.high);
  for (const float v : found.view_values)
    found.region.coverage += std::abs(v) > kShown * full ? 1 / float(set.views.size()) : 0;
  return found;
}

}  // namespace

fs::path attributes_path(const Project& project) { return project.folder / "attributes.json"; }

Result<PaintedAttributes> read_project_attributes(const Project& project) {
  if (!path_exists(attributes_path(project))) return PaintedAttributes{};
  return read_attributes(attributes_path(project));
}

Result<void> save_project_attributes(const Project& project, const PaintedAttributes& attributes) {
  if (!attributes.empty()) return write_attributes(attributes_path(project), attributes);
  std::error_code failure;
  fs::remove(attributes_path(project), failure);
  if (failure) return file_error(attributes_path(project), "remove", failure.value());
  return {};
}

Result<void> save_attribute_changes(const Project& project, const PaintedAttributes& base,
                                    const PaintedAttributes& attributes) {
  auto there = read_project_attributes(project);
  if (!there) return there.error();
  return save_project_attributes(project, merge_attributes(base, attributes, std::move(*there)));
}

Result<fs::path> set_aside_attributes(const Project& project) {
  fs::path aside = project.folder / "attributes.old.json";
  for (int number = 2; path_exists(aside); ++number)
    aside = project.folder / fmt::format("attributes-{}.old.json", number);
  std::error_code failure;
  fs::rename(attributes_path(project), aside, failure);
  if (failure) return file_error(attributes_path(project), "rename", failure.value());
  return aside;
}

std::string attributes_hash(const Project& project) {
  if (!path_exists(attributes_path(project))) return {};
  const auto hash = hash_file(attributes_path(project));
  return hash ? *hash : "unreadable";
}

Result<void> check_annotation(const Project& project, std::string_view name,
                              const AttributeAnnotation& annotation) {
  if (const auto named = check_attribute_name(name); !named) return named;
  if (!(std::abs(annotation.value) <= 1))
    return Error{ErrorCode::bad_input, fmt::format("{} is not an amount of an attribute.", annotation.value),
                 "Give a number from -1 to 1; 0 is how the person mostly is.", "attribute"};
  const auto model = project_head_model(project.options);
  if (!model) return model.error();
  if (find_action(*model, name) != nullptr)
    return Error{ErrorCode::bad_input, fmt::format("The head model already has an action '{}'.", name),
                 "Use that one, or give the attribute another name.", "attribute"};
  if (const auto painted = read_project_attributes(project);
      painted && painted->size() >= std::size_t(kMaxAttributes) &&
      std::ranges::find(*painted, name, &PaintedAttribute::name) == painted->end())
    return Error{ErrorCode::bad_input,
                 fmt::format("There are already {} attributes, which is the limit.", kMaxAttributes),
                 "Remove one first.", "attribute"};
  const auto capture = read_capture(capture_path(project));
  if (!capture) return capture.error();
  const auto frame = std::ranges::find(capture->frames, annotation.frame, &CaptureFrame::frame);
  const auto refused = [&](const std::string& why) {
    return Error{ErrorCode::bad_input,
                 fmt::format("Frame {} cannot be painted on: {}.", annotation.frame, why),
                 "Choose another frame.", "attribute"};
  };
  if (frame == capture->frames.end()) return refused("the project does not hold it");
  if (frame->held_out) return refused("it is held out to measure on");
  if (!frame->used || std::ranges::find(project.options.train.left_out, annotation.frame) !=
                          project.options.train.left_out.end())
    return refused("nothing is learnt from it");
  return {};
}

Result<std::vector<FoundAttribute>> find_attributes(const Project& project, const PaintedAttributes& painted,
                                                    const TrainingSet& set, const Progress& progress,
                                                    std::stop_token stop, const RegionOptions& region) {
  std::vector<FoundAttribute> found;
  if (painted.empty()) return found;
  if (painted.size() > std::size_t(kMaxAttributes))
    return Error{ErrorCode::bad_input, fmt::format("{} attributes are too many.", painted.size()),
                 fmt::format("Keep {} at most.", kMaxAttributes), attributes_path(project).string()};
  const HeadShape shape = shape_head(set.model, set.person);
  const auto frames = gather_frames(project, set, stop);
  if (!frames) return frames.error();
  const std::vector<Eigen::VectorXf> asides = asides_of(*frames, set, shape);
  const std::vector<Vec3f> rest = pose_head(set.model, shape, typical_articulation(set));
  for (std::size_t a = 0; a < painted.size(); ++a) {
    if (stop.stop_requested()) return cancelled_error();
    progress.report(double(a) / double(painted.size()), fmt::format("attribute {}", painted[a].name));
    auto one = find_attribute(painted[a], set, *frames, shape, asides, rest, region);
    if (!one) return one.error();
    found.push_back(std::move(*one));
  }
  return found;
}

void take_attributes(const std::vector<FoundAttribute>& found, TrainingSet& set) {
  set.attributes.clear();
  for (TrainingView& view : set.views) view.pose.attributes.clear();
  for (const FoundAttribute& attribute : found) {
    set.attributes.push_back(attribute.region);
    for (std::size_t v = 0; v < set.views.size(); ++v)
      set.views[v].pose.attributes.push_back(attribute.view_values[v]);
  }
}

Result<std::vector<FoundAttribute>> add_attributes(const Project& project, TrainingSet& set,
                                                   const Progress& progress, std::stop_token stop) {
  const auto painted = read_project_attributes(project);
  if (!painted) return painted.error();
  auto found = find_attributes(project, *painted, set, progress, stop);
  if (found) take_attributes(*found, set);
  return found;
}

}  // namespace likeness
