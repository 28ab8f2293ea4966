// The training of a project's avatar: see stage_run.h.
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/files.h"
#include "core/base/memory.h"
#include "core/base/path_text.h"
#include "core/project/project_attributes.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/project/stage_run.h"
#include "core/project/training_curve.h"
#include "core/project/training_options.h"
#include "core/project/training_set.h"
#include "core/project/what_holds.h"
#include "core/render/room_picture.h"
#include "core/train/memory_forecast.h"

namespace likeness {

namespace fs = std::filesystem;

namespace {

// Writes the training's curve to disk every few seconds and at the end. A failure to write fails no training.
class CurveKeeper {
 public:
  explicit CurveKeeper(fs::path path) : path_(std::move(path)) {
    if (auto earlier = read_training_curve(path_)) curve_ = std::move(*earlier);
  }
  void add(const TrainStatus& status) {
    // A continued training first reports a later step; a new one, or one that had hardly begun, starts its
    // own curve.
    constexpr std::uint64_t kBeginning = 100;
    if (!reported_ && status.step < kBeginning) curve_ = {};
    reported_ = true;
    add_point(curve_, status);
    constexpr double kEvery_s = 15;
    if (status.seconds - written_at_s_ >= 0 && status.seconds - written_at_s_ < kEvery_s) return;
    written_at_s_ = status.seconds;
    write();
  }
  void write() const {
    if (!curve_.training.empty()) (void)write_training_curve(path_, curve_);
  }

 private:
  fs::path path_;
  TrainingCurve curve_;
  bool reported_ = false;
  double written_at_s_ = -1e9;
};

// Reports the painted attributes, and keeps their amounts for pictures of the clip's own frames by the avatar
// that is being trained: in a file of their own, as the last avatar's stay until there is a new one.
Result<void> keep_courses(const StageContext& context, const std::vector<FoundAttribute>& found) {
  if (found.empty()) return {};
  std::vector<AttributeCourse> courses;
  context.record.warnings.clear();
  for (const FoundAttribute& attribute : found) {
    const AttributeCourse& course = courses.emplace_back(attribute.course);
    context.progress.report(0, "attribute " + course_words(course));
    if (4 * course.unlike_any > int(course.frames.size()))
      context.record.warnings.push_back(fmt::format(
          "Of attribute '{}', {} of {} frames look like none that was painted; paint it on some of those.",
          course.name, course.unlike_any, course.frames.size()));
  }
  return write_attribute_values(next_attribute_values_path(context.project), courses);
}

// Looks how far the avatar holds beyond the clip. A look that was stopped or failed fails no training: it is
// made when somebody asks.
void find_what_holds(const StageContext& context, const HeadModel& model, Avatar& avatar) {
  auto holds = what_holds(avatar, model, {context.place.backend, context.place.fall_back, {}},
                          context.progress.stage(1, 1, "what holds"), context.stop);
  if (holds) {
    avatar.holds = std::move(*holds);
  } else if (holds.error().code != ErrorCode::cancelled) {
    context.record.warnings.push_back("How far the avatar holds could not be found. " + holds.error().what);
  }
}

}  // namespace

Result<void> run_train(const StageContext& context) {
  const TrainInputs& inputs = context.inputs.train;
  const auto model = head_model_at(inputs.head_model);
  if (!model) return model.error();
  auto set = load_training_views(context.project, *model);
  if (!set) return set.error();
  TrainOptions options = training_options(inputs);
  options.place = context.place;
  const MemoryForecast forecast = forecast_memory(*set, options);
  context.progress.report(0, fmt::format("training takes about {:.1f} GiB of memory",
                                         double(forecast.total()) / double(1ull << 30)));
  if (const auto available = available_memory())
    if (const auto enough = check_memory(forecast, *available); !enough) return enough.error();
  if (const auto loaded = load_training_pictures(context.project, *set); !loaded) return loaded.error();
  const auto attributes =
      add_attributes(context.project, *set, context.progress.stage(0, 0, "attributes"), context.stop);
  if (!attributes) return attributes.error();
  if (const auto kept = keep_courses(context, *attributes); !kept) return kept.error();
  const ChosenParts chosen = take_parts(context.project, *set, options);
  context.observer.parts(chosen.parts);
  CurveKeeper curve(training_curve_path(context.project));
  const auto observe = [&](const TrainStatus& status) {
    curve.add(status);
    context.observer.training(status);
  };
  auto avatar = train_avatar(*set, options, checkpoint_path(context.project), context.progress, observe,
                             context.stop, context.observer.tap);
  curve.write();
  if (!avatar) return avatar.error();
  if (path_exists(room_path(context.project))) {
    auto room = read_room(room_path(context.project));
    if (!room) return room.error();
    avatar->room = std::move(*room);
  }
  avatar->background_fault = project_background_fault(context.project);
  avatar->head_model_file = text_of_path(inputs.head_model);
  avatar->parts = chosen.parts;
  find_what_holds(context, *model, *avatar);
  context.record.message = fmt::format("{} steps in {:.0f} s.", avatar->steps, avatar->train_seconds);
  for (const FoundAttribute& attribute : *attributes)
    context.record.message += " Attribute " + course_words(attribute.course);
  if (const auto written = write_avatar(avatar_path(context.project), *avatar); !written) return written;
  std::error_code failure;
  if (attributes->empty())
    fs::remove(next_attribute_values_path(context.project), failure),
        fs::remove(attribute_values_path(context.project), failure);
  else
    fs::rename(next_attribute_values_path(context.project), attribute_values_path(context.project), failure);
  return failure ? Result<void>(file_error(attribute_values_path(context.project), "write", failure.value()))
                 : Result<void>();
}

}  // namespace likeness
