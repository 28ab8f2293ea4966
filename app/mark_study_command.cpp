// likeness study marks: a track beside what somebody saw in the pictures.
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/lab/truth/face_marks.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"
#include "core/scene/track.h"

namespace likeness::app {

namespace fs = std::filesystem;

namespace {

struct MarkStudyArguments {
  CommonOptions common;
  fs::path track, marks;
  ProjectOptions models;  // head model only
};

struct MarkStudy {
  int frames = 0, good = 0, weak = 0, lost = 0;
  MarkScore score;
};

Result<MarkStudy> study_marks(const MarkStudyArguments& a) {
  const auto track = read_track(a.track);
  if (!track) return track.error();
  ProjectOptions models = a.models;
  if (models.shared.head_model.empty()) models.shared.head_model = track->head_model_file;
  const auto model = project_head_model(models);
  if (!model) return model.error();
  if (const auto fits = check_track_fits(*track, *model); !fits) {
    return Error{ErrorCode::bad_input, fits.error().what,
                 "Name the track's own head model with --head-model.", a.track.string()};
  }
  const auto marks = read_face_marks(a.marks);
  if (!marks) return marks.error();
  MarkStudy study{int(track->frames.size()), 0, 0, 0, score_marks(*track, *model, *marks)};
  for (const TrackedFrame& frame : track->frames)
    ++(frame.status == FrameStatus::good   ? study.good
       : frame.status == FrameStatus::weak ? study.weak
                                           : study.lost);
  return study;
}

int run(const MarkStudyArguments& a) {
  const auto study = study_marks(a);
  if (!study) return report_failure(study.error());
  const MarkScore& s = study->score;
  if (a.common.json) {
    print_json({{"frames", study->frames},
                {"good", study->good},
                {"weak", study->weak},
                {"lost", study->lost},
                {"marked_good", s.placed},
                {"misplaced", s.misplaced},
                {"marked_mouths", s.mouths},
                {"wrong_mouths", s.wrong_mouths},
                {"marked_eyes", s.eyes},
                {"wrong_eyes", s.wrong_eyes}});
    return kExitDone;
  }
  fmt::print("{} frames: {} good ({:.1f} %), {} weak, {} lost\n", study->frames, study->good,
             study->frames > 0 ? 100.0 * study->good / study->frames : 0.0, study->weak, study->lost);
  fmt::print("of {} good ones looked at {} wrong [{}]\n", s.placed, s.misplaced.size(),
             fmt::join(s.misplaced, " "));
  fmt::print("mouths as marked {} of {}, wrong in frames [{}]\n", s.mouths - int(s.wrong_mouths.size()),
             s.mouths, fmt::join(s.wrong_mouths, " "));
  fmt::print("eyes as marked {} of {}, wrong in frames [{}]\n", s.eyes - int(s.wrong_eyes.size()), s.eyes,
             fmt::join(s.wrong_eyes, " "));
  return kExitDone;
}

}  // namespace

void add_mark_study(CLI::App& study, int& exit_code) {
  auto a = std::make_shared<MarkStudyArguments>();
  CLI::App* verb = study.add_subcommand("marks", "A track beside what somebody saw in the clip's pictures");
  verb->add_option("track", a->track, "A track.json of the clip")->required();
  verb->add_option("marks", a->marks, "The marks (core/lab/truth/face_marks.h)")->required();
  verb->add_option("--head-model", a->models.shared.head_model,
                   "The head model of the track; default: the one it names, or the built-in head");
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
