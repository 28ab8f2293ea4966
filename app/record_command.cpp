// likeness record: a clip from a webcam.
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/consent_option.h"
#include "app/terminal.h"
#include "core/video/finish_film.h"
#include "core/video/record.h"
#include "core/video/webcam.h"

namespace likeness::app {
namespace {

struct RecordArguments {
  CommonOptions common;
  std::filesystem::path clip;
  std::string webcam, consent;
  bool list = false;
  RecordOptions options;
};

int list(const std::vector<Webcam>& webcams, bool json) {
  if (json) {
    nlohmann::json entries = nlohmann::json::array();
    for (const Webcam& w : webcams) entries.push_back({{"device", w.device}, {"name", w.name}});
    print_json({{"webcams", entries}});
    return kExitDone;
  }
  for (const Webcam& w : webcams) fmt::print("{}  {}\n", w.device, w.name);
  if (webcams.empty()) fmt::print("No webcam was found.\n");
  return kExitDone;
}

int run(const RecordArguments& arguments) {
  if (arguments.list) return list(list_webcams(), arguments.common.json);
  const auto consent = answered_consent(arguments.consent, !arguments.common.json);
  if (!consent) return report_failure(consent.error());
  const std::filesystem::path folder =
      arguments.clip.has_parent_path() ? arguments.clip.parent_path() : std::filesystem::path(".");
  for (const std::filesystem::path& film : finish_abandoned_films(folder))
    tell("A recording that was broken off is now in {}.\n", film.string());
  auto source = open_webcam(arguments.webcam, kToRecord);
  if (!source) return report_failure(source.error());
  if (!arguments.common.json)
    tell("Recording; Ctrl-C ends it and keeps the clip.{}\n",
         *consent == Consent::not_asked ? " Film only people who have agreed to it." : "");
  std::optional<Result<Recording>> recording;
  {
    const ProgressLine line(arguments.common);
    const Progress progress = line.progress().stage(0, 1, "recording");
    std::optional<double> start;
    const auto seen = [&](const CapturedFrame& picture) {
      if (!start) start = picture.time_s;
      const double seconds = picture.time_s - *start;
      progress.report(seconds / arguments.options.longest_s, fmt::format("{:.0f} s", seconds));
    };
    recording = record_clip(**source, arguments.clip, arguments.options, seen, stop_on_signals());
  }
  if (!*recording) return report_failure(recording->error());
  const Recording& r = **recording;
  if (r.interruption) tell("The recording was cut short: {} {}\n", r.interruption->what, r.interruption->fix);
  if (arguments.common.json) {
    print_json({{"video", arguments.clip.string()},
                {"frames", r.frames},
                {"seconds", r.seconds},
                {"repeated", r.repeated},
                {"broken_off", r.interruption.has_value()},
                {"left_out", r.left_out}});
  } else {
    tell("Wrote {:.1f} s to {}. Next: likeness check {}\n", r.seconds, arguments.clip.string(),
         arguments.clip.string());
  }
  return kExitDone;
}

}  // namespace

void add_record_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<RecordArguments>();
  CLI::App* verb = program.add_subcommand("record", "Record a clip from a webcam");
  CLI::Option* clip = verb->add_option("clip", a->clip, "The .mp4 to write");
  CLI::Option* listing = verb->add_flag("--list", a->list, "Name the webcams, record nothing");
  verb->add_option("--webcam", a->webcam,
                   "The webcam's device, for instance /dev/video0; default: the first");
  verb->add_option("--seconds", a->options.longest_s, "Longest recording")->check(CLI::Range(1.0, 3600.0));
  add_consent_option(*verb, a->consent);
  add_common_options(*verb, a->common);
  verb->callback([a, clip, listing, &exit_code] {
    if (listing->count() == 0 && clip->count() == 0) throw CLI::RequiredError("clip");
    exit_code = run(*a);
  });
}

}  // namespace likeness::app
