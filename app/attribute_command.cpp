// likeness attribute: what no expression carries, painted on a few frames; also listed, removed, and reported
// frame by frame.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/image/files.h"
#include "core/project/project_attributes.h"
#include "core/project/project_head_model.h"
#include "core/project/training_set.h"
#include "core/train/attribute_values.h"

namespace likeness::app {

namespace {

struct AttributeArguments {
  CommonOptions common;
  std::filesystem::path project, region;
  std::string name;
  std::vector<double> box;
  int frame = -1;
  double value = 0;
};

int done(const AttributeArguments& a, const std::string& words) {
  if (a.common.json)
    print_json({{"project", a.project.string()}, {"attribute", a.name}});
  else
    tell("{}\n", words);
  return kExitDone;
}

// The strokes that --region or --box gives; empty without either.
Result<Strokes> region_of(const AttributeArguments& a, const Project& project) {
  const auto capture = read_capture(capture_path(project));
  if (!capture) return capture.error();
  Strokes strokes;
  if (!a.region.empty()) {
    const auto mask = read_image(a.region);
    if (!mask) return mask.error();
    if (mask->width != capture->width || mask->height != capture->height)
      return Error{ErrorCode::bad_input,
                   fmt::format("The region is {} x {}, the clip {} x {}.", mask->width, mask->height,
                               capture->width, capture->height),
                   "Paint it on a picture of the clip's size.", a.region.string()};
    Image8 first(mask->width, mask->height, 1);
    for (std::size_t i = 0; i < first.data.size(); ++i)
      first.data[i] = mask->data[i * std::size_t(mask->channels)];
    strokes = strokes_of_mask(first);
  } else if (!a.box.empty()) {
    const Vec2d picture(capture->width, capture->height);
    const auto within = [&](double x, double y) {
      return Vec2d(Vec2d(std::isfinite(x) ? x : 0, std::isfinite(y) ? y : 0).cwiseMax(0).cwiseMin(picture));
    };
    const Vec2d low = within(a.box[0], a.box[1]), high = within(a.box[2], a.box[3]);
    if (!((high - low).minCoeff() >= 1))
      return Error{ErrorCode::bad_input, "The box is empty.",
                   "Give its left, upper, right and lower edge in the clip's pixels: --box X0,Y0,X1,Y1", ""};
    strokes = strokes_of_box(low, high);
  } else {
    return strokes;
  }
  const StrokeCover cover = cover_strokes(strokes, capture->crop, capture->size);
  const bool covers =
      !cover.empty() && std::ranges::any_of(cover.person.data, [](float c) { return c > 0.5f; });
  if (covers) return strokes;
  return Error{ErrorCode::bad_input, "The region covers nothing of the project's square picture.",
               "White (over 127) is the region; it must lie on the face.", a.region.string()};
}

int add(const AttributeArguments& a) {
  auto project = open_project(a.project);
  if (!project) return report_failure(project.error());
  const auto lock = ProjectLock::acquire(*project);
  if (!lock) return report_failure(lock.error());
  auto attributes = read_project_attributes(*project);
  if (!attributes) return report_failure(attributes.error());
  auto region = region_of(a, *project);
  if (!region) return report_failure(region.error());
  const AttributeAnnotation annotation{a.frame, a.value, std::move(*region)};
  if (const auto fine = check_annotation(*project, a.name, annotation); !fine)
    return report_failure(fine.error());
  annotate(*attributes, a.name, annotation);
  const auto entry = std::ranges::find(*attributes, a.name, &PaintedAttribute::name);
  const bool painted =
      std::ranges::any_of(entry->annotations, [](const auto& one) { return !one.region.empty(); });
  if (!painted)
    return report_failure(Error{ErrorCode::bad_input, fmt::format("Nothing says where '{}' is.", a.name),
                                "Give its first frame a region: --region FILE.png or --box X0,Y0,X1,Y1", ""});
  if (const auto saved = save_project_attributes(*project, *attributes); !saved)
    return report_failure(saved.error());
  return done(a, fmt::format("'{}' is {:.2f} in frame {} ({} frames painted). Next, when there are some that "
                             "show it and some that do not: likeness train {}",
                             a.name, a.value, a.frame, entry->annotations.size(), a.project.string()));
}

int remove(const AttributeArguments& a) {
  auto project = open_project(a.project);
  if (!project) return report_failure(project.error());
  const auto lock = ProjectLock::acquire(*project);
  if (!lock) return report_failure(lock.error());
  auto attributes = read_project_attributes(*project);
  if (!attributes) return report_failure(attributes.error());
  if (!take_back(*attributes, a.name, a.frame))
    return report_failure(
        Error{ErrorCode::not_found,
              a.frame < 0 ? fmt::format("There is no attribute '{}'.", a.name)
                          : fmt::format("'{}' was not painted on frame {}.", a.name, a.frame),
              fmt::format("See what there is: likeness attribute list {}", a.project.string()), ""});
  if (const auto saved = save_project_attributes(*project, *attributes); !saved)
    return report_failure(saved.error());
  return done(a, fmt::format("'{}' was removed.", a.name));
}

int list(const AttributeArguments& a) {
  const auto project = open_project(a.project);
  if (!project) return report_failure(project.error());
  const auto attributes = read_project_attributes(*project);
  if (!attributes) return report_failure(attributes.error());
  if (a.common.json) {
    nlohmann::json all = nlohmann::json::array();
    for (const PaintedAttribute& attribute : *attributes) {
      nlohmann::json frames = nlohmann::json::array();
      for (const AttributeAnnotation& one : attribute.annotations)
        frames.push_back({{"frame", one.frame}, {"value", one.value}, {"strokes", one.region.size()}});
      all.push_back({{"name", attribute.name}, {"annotations", frames}});
    }
    print_json({{"attributes", all}});
    return kExitDone;
  }
  if (attributes->empty()) fmt::print("No attributes were painted.\n");
  for (const PaintedAttribute& attribute : *attributes) {
    fmt::print("{}\n", attribute.name);
    for (const AttributeAnnotation& one : attribute.annotations)
      fmt::print("  frame {:<6} {:>5.2f}{}\n", one.frame, one.value, one.region.empty() ? "" : "  painted");
  }
  return kExitDone;
}

// What a training would take: regions and amounts, without training.
Result<std::vector<FoundAttribute>> find_now(const AttributeArguments& a, const Progress& progress) {
  const auto project = open_project(a.project);
  if (!project) return project.error();
  const auto painted = read_project_attributes(*project);
  if (!painted) return painted.error();
  PaintedAttributes chosen;
  for (const PaintedAttribute& attribute : *painted)
    if (a.name.empty() || attribute.name == a.name) chosen.push_back(attribute);
  if (chosen.empty())
    return Error{
        ErrorCode::not_found,
        a.name.empty() ? "No attributes were painted." : fmt::format("There is no attribute '{}'.", a.name),
        "Paint one: likeness attribute add PROJECT NAME --frame N --value V --region FILE.png", ""};
  const auto model = project_head_model(project->options);
  if (!model) return model.error();
  const auto set = load_training_set(*project, *model);
  if (!set) return set.error();
  return find_attributes(*project, chosen, *set, progress, stop_on_signals());
}

int values(const AttributeArguments& a) {
  const ThreadLimit limit(a.common.threads);
  std::optional<Result<std::vector<FoundAttribute>>> found;
  {
    const ProgressLine line(a.common);
    found = find_now(a, line.progress());
  }
  if (!*found) return report_failure(found->error());
  if (a.common.json) {
    nlohmann::json all = nlohmann::json::array();
    for (const FoundAttribute& one : **found)
      all.push_back({{"name", one.course.name},
                     {"frames", one.course.frames},
                     {"values", one.course.values},
                     {"doubts", one.course.doubts},
                     {"painted_frames", one.course.painted_frames},
                     {"left_out_error", one.course.left_out_error},
                     {"unlike_any", one.course.unlike_any}});
    print_json({{"attributes", all}});
    return kExitDone;
  }
  for (const FoundAttribute& one : **found) {
    fmt::print("{}\n", course_words(one.course));
    for (std::size_t i = 0; i < one.course.frames.size(); ++i)
      fmt::print("  frame {:<6} {:>5.2f}{}\n", one.course.frames[i], one.course.values[i],
                 one.course.annotated[i]             ? "  painted"
                 : one.course.doubts[i] > kUnlikeAny ? "  looks like none of the painted ones"
                                                     : "");
  }
  return kExitDone;
}

}  // namespace

void add_attribute_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<AttributeArguments>();
  CLI::App* verb =
      program.add_subcommand("attribute",
                             "Paint what no expression carries - a puffed cheek, a dimple - on a few frames; "
                             "the next training makes a slider of it");
  verb->require_subcommand(1);
  const auto add_project = [&a](CLI::App* of) {
    of->add_option("project", a->project, "Project folder")->required();
  };

  CLI::App* add_verb = verb->add_subcommand("add", "Say how much of it a frame shows, and where");
  add_project(add_verb);
  add_verb->add_option("name", a->name, "The attribute's name, which the slider gets")->required();
  add_verb->add_option("--frame", a->frame, "Number of the frame in the clip")
      ->required()
      ->check(CLI::NonNegativeNumber);
  add_verb->add_option("--value", a->value, "-1 to 1; 0: as the person mostly is")
      ->required()
      ->check(CLI::Range(-1.0, 1.0));
  CLI::Option* region =
      add_verb->add_option("--region", a->region, "A picture of the clip's size, white where it is");
  add_verb->add_option("--box", a->box, "Or a box: X0,Y0,X1,Y1 in the clip's pixels")
      ->delimiter(',')
      ->expected(4)
      ->excludes(region);
  add_common_options(*add_verb, a->common);
  add_verb->callback([a, &exit_code] { exit_code = add(*a); });

  CLI::App* remove_verb = verb->add_subcommand("remove", "Remove it, on one frame or altogether");
  add_project(remove_verb);
  remove_verb->add_option("name", a->name, "Its name")->required();
  remove_verb->add_option("--frame", a->frame, "Only this frame")->check(CLI::NonNegativeNumber);
  add_common_options(*remove_verb, a->common);
  remove_verb->callback([a, &exit_code] { exit_code = remove(*a); });

  CLI::App* list_verb = verb->add_subcommand("list", "What was painted");
  add_project(list_verb);
  add_common_options(*list_verb, a->common);
  list_verb->callback([a, &exit_code] { exit_code = list(*a); });

  CLI::App* values_verb =
      verb->add_subcommand("values", "How much of it every tracked frame shows, as a training would take it");
  add_project(values_verb);
  values_verb->add_option("name", a->name, "Only this one");
  add_common_options(*values_verb, a->common);
  values_verb->callback([a, &exit_code] { exit_code = values(*a); });
}

}  // namespace likeness::app
