// likeness card: what an avatar learnt from its capture, what it never saw, and what to film again.
#include <memory>
#include <numbers>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/holds_json.h"
#include "app/parts.h"
#include "app/terminal.h"
#include "core/base/parallel.h"
#include "core/holds/hold_words.h"
#include "core/project/card.h"
#include "core/project/consent.h"
#include "core/project/open_avatar.h"
#include "core/project/what_holds.h"

namespace likeness::app {

namespace {

struct CardArguments {
  CommonOptions common;
  std::filesystem::path project;
};

constexpr double kDegrees = 180 / std::numbers::pi;

nlohmann::json to_json(const Card& card, Consent consent) {
  using nlohmann::json;
  json expressions = json::array(), gaps = json::array(), worst = json::array();
  for (const CardExpression& e : card.expressions)
    expressions.push_back({{"name", e.name}, {"most", e.most}, {"learnt", kLearnt[std::size_t(e.learnt)]}});
  for (const CardGap& gap : card.gaps) gaps.push_back({{"what", gap.what}, {"film_again", gap.film_again}});
  for (const CardMoment& m : card.worst)
    worst.push_back({{"from_s", m.from_s},
                     {"to_s", m.to_s},
                     {"badness", m.badness},
                     {"what", m.what},
                     {"film_again", m.film_again}});
  json holds_gaps = json::array();
  if (card.holds)
    for (const HoldRemark& remark : hold_remarks(*card.holds))
      holds_gaps.push_back({{"what", remark.what}, {"film_again", remark.film_again}});
  const auto range = [](double low, double high) { return json{low * kDegrees, high * kDegrees}; };
  return {
      {"consent", consent_name(consent)},
      {"frames",
       {{"trained", card.trained}, {"weak", card.weak}, {"lost", card.lost}, {"refused", card.refused}}},
      {"seen_from_deg",
       {{"yaw", range(card.low.yaw, card.high.yaw)},
        {"pitch", range(card.low.pitch, card.high.pitch)},
        {"roll", range(card.low.roll, card.high.roll)}}},
      {"expressions", expressions},
      {"mouth", {{"widest", card.mouth.widest}, {"smile", card.mouth.smile}, {"teeth", card.mouth.teeth}}},
      {"gaps", gaps},
      {"holds", card.holds ? holds_json(*card.holds) : json()},
      {"holds_gaps", holds_gaps},
      {"parts", parts_json(card.parts)},
      {"worst", worst}};
}

void print_card(const Card& card) {
  fmt::print("{} frames trained; {} weak, {} lost, {} refused.\n", card.trained, card.weak, card.lost,
             card.refused);
  fmt::print("Seen from {:.0f} degrees on the right to {:.0f} on the left, {:.0f} below to {:.0f} above.\n",
             -card.low.yaw * kDegrees, card.high.yaw * kDegrees, -card.low.pitch * kDegrees,
             card.high.pitch * kDegrees);
  for (const Learnt learnt : {Learnt::well, Learnt::little, Learnt::never}) {
    std::string names;
    for (const CardExpression& e : card.expressions)
      if (e.learnt == learnt) names += (names.empty() ? "" : ", ") + e.name;
    constexpr const char* kTitles[] = {"Never seen", "Seen a little", "Learnt well"};
    fmt::print("{}: {}.\n", kTitles[std::size_t(learnt)], names.empty() ? "nothing" : names);
  }
  if (card.holds) {
    fmt::print("\n{}\n", range_words(*card.holds));
    for (const HoldRemark& remark : hold_remarks(*card.holds))
      fmt::print("  {}\n    {}\n", remark.what, remark.film_again);
  }
  if (!card.gaps.empty()) fmt::print("\nTo film in addition\n");
  for (const CardGap& gap : card.gaps) fmt::print("  {}\n    {}\n", gap.what, gap.film_again);
  fmt::print("\nThe worst moments{}\n", card.worst.empty() ? ": none, the track is even." : "");
  for (const CardMoment& m : card.worst)
    fmt::print("  {:.1f} to {:.1f} s. {}\n    {}\n", m.from_s, m.to_s, m.what, m.film_again);
  if (card.parts.empty()) return;
  fmt::print("\nParts of this avatar, and why\n");
  fmt::print("{}", parts_text(card.parts));
}

// Of an avatar from before trainings looked for it.
Result<HoldingRange> found_now(const CardArguments& arguments) {
  const auto opened = open_avatar(arguments.project);
  if (!opened) return opened.error();
  const ProgressLine line(arguments.common);
  return what_holds(opened->avatar, opened->model, {}, line.progress().stage(0, 1, "what holds"),
                    stop_on_signals());
}

int run(const CardArguments& arguments) {
  const ThreadLimit limit(arguments.common.threads);
  const auto project = open_project(arguments.project);
  if (!project) return report_failure(project.error());
  auto card = project_card(*project);
  if (!card) return report_failure(card.error());
  if (!card->holds) {
    const auto holds = found_now(arguments);
    if (!holds && holds.error().code == ErrorCode::cancelled) return report_failure(holds.error());
    if (holds) {
      card->holds = *holds;
    } else {
      tell("How far the avatar holds could not be found. {}\n", holds.error().what);
    }
  }
  if (arguments.common.json) {
    print_json(to_json(*card, project->consent));
  } else {
    print_card(*card);
    if (project->consent == Consent::not_asked)
      fmt::print(
          "\nWhether the filmed person agreed was never answered; exports say so.\n"
          "  likeness train {} --consent self, given or nobody\n",
          project->folder.string());
  }
  return kExitDone;
}

}  // namespace

void add_card_command(CLI::App& program, int& exit_code) {
  auto a = std::make_shared<CardArguments>();
  CLI::App* verb = program.add_subcommand("card", "What an avatar learnt, never saw, and what to film again");
  verb->add_option("project", a->project, "Project folder of the avatar")->required();
  add_common_options(*verb, a->common);
  verb->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace likeness::app
