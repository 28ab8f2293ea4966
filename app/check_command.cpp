// likeness check: will this clip make an avatar?
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/check/check_page.h"
#include "core/check/checked_clip.h"
#include "core/check/verdict.h"
#include "core/face/landmarks.h"
#include "core/image/files.h"

namespace likeness::app {
namespace {

namespace fs = std::filesystem;

struct CheckArguments {
  CommonOptions common;
  fs::path video, landmark_model, person_network, picture;
};

nlohmann::json to_json(const Look& look) {
  nlohmann::json j{{"frame", look.frame},
                   {"time_s", look.time_s},
                   {"face", look.face.has_value()},
                   {"second_face", look.second_face}};
  if (!look.face) return j;
  j["face_px"] = look.face->width;
  j["sharpness"] = look.sharpness;
  j["level"] = look.level;
  j["dark_share"] = look.dark_share;
  j["bright_share"] = look.bright_share;
  j["cut_share"] = look.cut_share;
  if (!look.posed) return j;
  j["yaw_deg"] = look.yaw_deg;
  j["pitch_deg"] = look.pitch_deg;
  j["open_mouth"] = look.expressions[std::size_t(KeyExpression::open_mouth)];
  j["smile"] = look.expressions[std::size_t(KeyExpression::smile)];
  j["pucker"] = look.expressions[std::size_t(KeyExpression::pucker)];
  j["raise_brows"] = look.expressions[std::size_t(KeyExpression::raise_brows)];
  j["shut_eyes"] = look.expressions[std::size_t(KeyExpression::shut_eyes)];
  return j;
}

void print_as_json(const ClipMeasures& measures, const CaptureVerdict& verdict) {
  nlohmann::json looks = nlohmann::json::array();
  for (const Look& look : measures.looks) looks.push_back(to_json(look));
  nlohmann::json shots = nlohmann::json::array();
  for (const ClipShot& shot : measures.shots)
    shots.push_back(
        {{"from_s", shot.from_s}, {"to_s", shot.to_s}, {"used", shot.used}, {"reason", shot.reason}});
  const CameraMeasures& camera = measures.camera;
  const ClipFacts facts = clip_facts(measures);
  const PixelRect& f = measures.film;
  const nlohmann::json film = f.empty() ? nlohmann::json() : nlohmann::json{f.x, f.y, f.width, f.height};
  print_json({{"verdict", verdict_name(verdict.verdict)},
              {"remarks", remarks_json(verdict.remarks)},
              {"frames", measures.frames},
              {"seconds", measures.duration_s},
              {"film", film},
              {"repeated_frames", measures.repeated},
              {"person_network",
               {{"used", measures.has_person_network},
                {"faces", measures.faces},
                {"persons_seen", measures.persons_seen}}},
              {"words",
               {{"camera", camera_sentence(facts.camera)},
                {"mask", mask_sentence(facts.mask)},
                {"parts", parts_sentence(facts.parts)}}},
              {"shots", shots},
              {"camera",
               {{"rests", camera.rests},
                {"kind", camera_kind_name(camera.kind)},
                {"sure", camera.sure},
                {"evidence", camera.evidence},
                {"motion_per_1000", camera.motion},
                {"travel_per_1000", camera.travel},
                {"reach_per_1000", camera.sway.reach},
                {"crossings_per_s", camera.sway.crossings},
                {"tracks", camera.tracks}}},
              {"looks", looks}});
}

Result<void> write_page(const CheckArguments& arguments, const ClipMeasures& measures,
                        const CaptureVerdict& verdict) {
  const ProgressLine line(arguments.common);
  const auto page = draw_check_page(arguments.video, measures, verdict,
                                    line.progress().stage(0, 1, "picture"), stop_on_signals());
  if (!page) return page.error();
  return write_image(arguments.picture, *page);
}

int run(const CheckArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  std::optional<Result<ClipMeasures>> measures;
  {
    const ProgressLine line(arguments.common);
    measures = measure_clip(arguments.video, arguments.landmark_model, arguments.person_network,
                            line.progress(), stop_on_signals());
  }
  if (!*measures) return report_failure(measures->error());
  const CaptureVerdict verdict = judge_capture(**measures);
  if (!arguments.picture.empty())
    if (const auto drawn = write_page(arguments, **measures, verdict); !drawn)
      return report_failure(drawn.error());
  if (arguments.common.json) {
    print_as_json(**measures, verdict);
    return kExitDone;
  }
  fmt::print("{}\n", verdict_words(verdict));
  const ClipFacts facts = clip_facts(**measures);
  for (const std::string& words :
       {camera_sentence(facts.camera), mask_sentence(facts.mask), parts_sentence(facts.parts)})
    fmt::print("  {}\n", words);
  for (const Remark& r : verdict.remarks)
    fmt::print("\n{} {:.0f}-{:.0f} s: {}\n  {}\n", r.grave ? "!" : "-", r.from_s, r.to_s, r.what, r.remedy);
  return kExitDone;
}

}  // namespace

void add_check_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<CheckArguments>();
  CLI::App* verb =
      program.add_subcommand("check", "Will this clip make an avatar? A verdict before anything is built");
  verb->add_option("video", a->video, "The clip, or a folder of photographs")->required();
  verb->add_option("--picture", a->picture, "Also draw the verdict on one page: a PNG or JPEG to write");
  verb->add_option("--landmark-model", a->landmark_model, kLandmarkModelHelp);
  verb->add_option("--person-network", a->person_network,
                   "A network (.onnx) that tells people from everything else, or none; default: the "
                   "installed one");
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
