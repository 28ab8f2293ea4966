// See matte_report.h.
#include "core/matte/matte_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/base/files.h"
#include "core/base/json_text.h"

namespace likeness {
namespace {

using nlohmann::json;

constexpr std::array<const char*, 4> kPriors{"none", "person_network", "matting_network", "clip"};

json to_json(const BackgroundFit& fit) {
  return {{"frames", fit.frames},
          {"held_out", fit.held_out},
          {"psnr_db", fit.psnr_db},
          {"constant_db", fit.constant_db}};
}

// Numbers as a report can have them.
bool is_sound(const BackgroundFit& fit) {
  return fit.frames >= 0 && std::isfinite(fit.psnr_db) && std::isfinite(fit.constant_db);
}

BackgroundFit fit_from(const json& j) {
  return {whole_number_in(j.at("frames")), j.at("held_out").get<bool>(), j.at("psnr_db").get<double>(),
          j.at("constant_db").get<double>()};
}

MatteReport report_from(const json& j) {
  MatteReport report;
  const auto prior = std::ranges::find(kPriors, j.at("prior").get<std::string>(),
                                       [](const char* name) { return std::string_view(name); });
  if (prior == kPriors.end()) throw json::other_error::create(501, "prior", &j);
  report.prior = MaskPrior(prior - kPriors.begin());
  report.frames = whole_number_in(j.at("frames")),
  report.prior_frames = whole_number_in(j.at("prior_frames"));
  report.plate_look_back = {whole_number_in(j.at("plate_frames")), j.at("plate_differing").get<double>()};
  report.has_mosaic = j.at("mosaic").get<bool>();
  if (j.contains("plate")) report.plate = fit_from(j.at("plate"));
  if (j.contains("room")) report.room = fit_from(j.at("room"));
  return report;
}

bool is_sound(const MatteReport& r) {
  return r.frames >= 0 && r.prior_frames >= 0 && r.prior_frames <= r.frames &&
         r.plate_look_back.frames >= 0 && r.plate_look_back.differing >= 0 &&
         r.plate_look_back.differing <= 1 && (!r.plate || is_sound(*r.plate)) &&
         (!r.room || is_sound(*r.room));
}

// what: stands behind the person.
std::string fault_of(const BackgroundFit& fit, std::string_view what) {
  return fmt::format(
      "The background was not learnt: {} hardly resembles what {} {}frame{} there ({:.1f} dB; {:.1f} are "
      "needed, one colour alone reaches {:.1f}).",
      what, fit.frames, fit.held_out ? "held-out " : "", fit.frames == 1 ? " shows" : "s show", fit.psnr_db,
      needed_db(fit), fit.constant_db);
}

}  // namespace

const char* mask_prior_name(MaskPrior prior) { return kPriors[std::size_t(prior)]; }

double needed_db(const BackgroundFit& fit) {
  return std::clamp(fit.constant_db + kBeyondOneColour_dB, kNeverLearnt_dB, kSurelyLearnt_dB);
}

bool is_learnt(const BackgroundFit& fit) { return fit.frames == 0 || fit.psnr_db >= needed_db(fit); }

bool holds(const PlateLookBack& look) { return look.frames == 0 || look.differing <= kMaxDiffering; }

std::string plate_fault(const MatteReport& report) {
  if (!report.plate || is_learnt(*report.plate)) return {};
  return fault_of(*report.plate, report.has_mosaic ? "the mosaic of it" : "the picture of it");
}

std::string room_fault(const MatteReport& report) {
  if (!report.room || is_learnt(*report.room)) return {};
  return fault_of(*report.room, "the room behind the moving camera") +
         (report.plate ? " It is not shown." : " It is not shown: a plain colour stands behind the person.");
}

std::string background_fault(const MatteReport& report) {
  return report.plate ? plate_fault(report) : room_fault(report);
}

std::string look_back_warning(const MatteReport& report, CameraKind kind) {
  const PlateLookBack& look = report.plate_look_back;
  if (holds(look)) return {};
  const std::string what =
      fmt::format("In {:.0f} % of {} frames the background differs from the picture that was learnt of it: ",
                  100 * look.differing, look.frames);
  if (kind == CameraKind::resting)
    return what +
           "the camera did not rest, or something behind the person moves. If a hand held it, choose "
           "\"held in the hand\" as what the camera does (--camera-kind handheld); if it went round "
           "the person, \"walking\".";
  if (kind == CameraKind::handheld)
    return what +
           "the camera did more than turn and zoom, or something behind the person moves. If it went "
           "round the person, choose \"walking\" as what the camera does (--camera-kind walking); "
           "otherwise rest the phone on something and film again.";
  return what +
         "the camera moved while it was taken to rest, or something behind the person moves. Film "
         "again before a wall where nothing moves.";
}

Result<void> write_matte_report(const std::filesystem::path& path, const MatteReport& report) {
  json j{{"format", "likeness-matte-report"},
         {"version", 1},
         {"prior", mask_prior_name(report.prior)},
         {"frames", report.frames},
         {"prior_frames", report.prior_frames},
         {"plate_frames", report.plate_look_back.frames},
         {"plate_differing", report.plate_look_back.differing},
         {"mosaic", report.has_mosaic}};
  if (report.plate) j["plate"] = to_json(*report.plate);
  if (report.room) j["room"] = to_json(*report.room);
  return write_text(path, json_text(j, 1) + "\n");
}

Result<std::optional<MatteReport>> read_matte_report(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return std::optional<MatteReport>{};
  const auto text = read_text(path);
  if (!text) return text.error();
  const Error bad{ErrorCode::bad_input, "This is not a matte_report.json of a version that Likeness reads.",
                  "Delete it and run the matte stage again (`likeness fit`).", path.string()};
  try {
    const auto j = parse_json(*text);
    if (j.value("format", "") != "likeness-matte-report" || j.value("version", 0) != 1) return bad;
    MatteReport report = report_from(j);
    if (!is_sound(report)) return bad;
    return std::optional(std::move(report));
  } catch (const json::exception&) {
    return bad;
  }
}

}  // namespace likeness
