// Ranges, gaps and bad moments in words: see card.h.
#include "core/project/card.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>

#include "core/base/quantile.h"
#include "core/head/action_amounts.h"
#include "core/holds/film_again.h"
#include "core/project/further_views.h"
#include "core/project/project_head_model.h"
#include "core/project/project_views.h"

namespace likeness {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr float kWell = 0.5f, kLittle = 0.2f;  // of an action's full amount
constexpr double kSide = 30 / kDegrees,
                 kAboveBelow = 12 / kDegrees;  // from where an avatar is usually viewed
constexpr double kFarTurn = 30 / kDegrees;
constexpr double kLostBadness = 3, kWeakBadness = 2, kBlurredBadness = 1.5, kWorthMentioning = 1.5;
constexpr double kWindow_s = 1, kApart_s = 2;

std::string_view without_side(std::string_view name) {
  return name.ends_with("_L") || name.ends_with("_R") ? name.substr(0, name.size() - 2) : name;
}

std::vector<CardExpression> expressions(const Avatar& avatar, const ActionBasis& basis,
                                        const SeenMouth& mouth) {
  const Eigen::VectorXf rest = action_amounts(basis, avatar.neutral);
  std::vector<CardExpression> list;
  for (const NamedAction& action : basis.actions) {
    const auto range = std::ranges::find(avatar.seen, action.name, &ActionRange::name);
    if (range == avatar.seen.end()) continue;
    const float most = std::max(0.0f, range->high - rest[action_index(basis, action.name)]);
    const std::string name(without_side(action.name));
    const auto known = std::ranges::find(list, name, &CardExpression::name);
    if (known == list.end()) {
      list.push_back({name, most});
    } else {
      known->most = std::min(known->most, most);
    }
  }
  // A smile is seen in the mouth's width and in teeth, even where the track has it as the face's shape.
  const float smiled = std::max(float(mouth.smile), mouth.teeth ? kWell : 0.0f);
  for (CardExpression& e : list)
    if (e.name == "mouthSmile") e.most = std::max(e.most, smiled);
  for (CardExpression& e : list)
    e.learnt = e.most >= kWell ? Learnt::well : e.most >= kLittle ? Learnt::little : Learnt::never;
  return list;
}

// -- Gaps

void add_view_gaps(const SeenViews& seen, std::vector<CardGap>& gaps) {
  const auto gap = [&](double reached, double wanted, HeadSide side) {
    if (reached >= 0.85 * wanted) return;
    gaps.push_back({fmt::format("Seen from {} only up to {:.0f} degrees of {:.0f}.", side_words(side),
                                std::max(0.0, reached) * kDegrees, wanted * kDegrees),
                    std::string(film_again_side(side))});
  };
  gap(seen.high.yaw, kSide, HeadSide::left);
  gap(-seen.low.yaw, kSide, HeadSide::right);
  gap(seen.high.pitch, kAboveBelow, HeadSide::above);
  gap(-seen.low.pitch, kAboveBelow, HeadSide::below);
}

void add_expression_gaps(const std::vector<CardExpression>& list, std::vector<CardGap>& gaps) {
  for (const FilmRequest& request : film_requests()) {
    const auto found = std::ranges::find(list, request.action, &CardExpression::name);
    if (found == list.end() || found->learnt == Learnt::well) continue;
    gaps.push_back(
        {found->learnt == Learnt::never
             ? fmt::format("{} was never seen: what it shows is the head model's guess.", request.what)
             : fmt::format("{} was seen only up to {:.0f} % of full.", request.what, 100 * found->most),
         std::string(request.words)});
  }
}

// -- Moments

struct CardFrame {
  double time_s = 0, badness = 1;
  bool lost = false, blurred = false, turned = false;
  const TrackedFrame* tracked = nullptr;
};

double usual_error(const Track& track) {
  std::vector<double> errors;
  for (const TrackedFrame& frame : track.frames)
    if (frame.status != FrameStatus::lost) errors.push_back(frame.inner_error_px);
  if (errors.empty()) return 1;
  return std::max(0.1, median(std::move(errors)));
}

bool is_blurred(const CaptureFrame& frame) { return frame.refused.starts_with("Blurred"); }
bool is_refused(const CaptureFrame& frame) {
  return is_blurred(frame) || frame.refused.starts_with("No face");
}

std::vector<CardFrame> card_frames(const Capture& capture, const CameraSet& cameras, const Track& track) {
  const double usual = usual_error(track);
  const std::vector<FrameSpan> serve = stretches_that_serve(capture);
  std::vector<CardFrame> frames;
  for (const CaptureFrame& captured : capture.frames) {
    if (span_of(serve, captured.frame) < 0 || captured.apart) continue;
    CardFrame frame{captured.time_s};
    frame.tracked = find_tracked(track, captured.frame);
    frame.blurred = is_blurred(captured);
    frame.lost = (is_refused(captured) && !frame.blurred) ||
                 (frame.tracked && frame.tracked->status == FrameStatus::lost);
    if (frame.tracked && !frame.lost) {
      frame.badness = frame.tracked->inner_error_px / usual;
      if (frame.tracked->status == FrameStatus::weak) frame.badness = std::max(frame.badness, kWeakBadness);
      if (const auto camera = picture_camera(capture, cameras, track, captured.frame)) {
        const ViewAngle view = view_angle(camera->cam_from_world * frame.tracked->pose.world_from_head);
        frame.turned = std::hypot(view.yaw, view.pitch) > kFarTurn;
      }
    }
    if (frame.blurred) frame.badness = std::max(frame.badness, kBlurredBadness);
    if (frame.lost) frame.badness = kLostBadness;
    frames.push_back(frame);
  }
  return frames;
}

// The request for the action that is furthest from rest there, or a general one.
std::string hold_it(const std::vector<const CardFrame*>& frames, const Avatar& avatar,
                    const ActionBasis& basis) {
  const Eigen::VectorXf rest = action_amounts(basis, avatar.neutral);
  std::map<std::string_view, float> amounts;
  for (const CardFrame* frame : frames) {
    if (!frame->tracked) continue;
    const Eigen::VectorXf shown = action_amounts(basis, frame->tracked->pose.articulation) - rest;
    for (Eigen::Index a = 0; a < shown.size(); ++a) {
      const std::string_view name = basis.actions[std::size_t(a)].name, both = without_side(name);
      amounts[both] += shown[a] / float(frames.size()) / (both == name ? 1 : 2);  // the mean of two sides
    }
  }
  const FilmRequest* strongest = nullptr;
  float most = kLittle;
  for (const FilmRequest& request : film_requests())
    if (const auto found = amounts.find(request.action); found != amounts.end() && found->second > most)
      most = found->second, strongest = &request;
  return strongest ? std::string(strongest->words)
                   : "Do the same again more slowly, the face in even light and uncovered.";
}

CardMoment describe(const std::vector<const CardFrame*>& frames, double badness, const Avatar& avatar,
                    const ActionBasis& basis) {
  const auto share = [&](auto&& which) {
    return double(std::ranges::count_if(frames, which)) / double(frames.size());
  };
  CardMoment moment{frames.front()->time_s, frames.back()->time_s, badness, "", ""};
  constexpr double kMany = 0.3;
  if (share([](const CardFrame* f) { return f->lost; }) > kMany) {
    moment.what = "The face was lost.";
    moment.film_again = "Keep the whole face in the picture, uncovered and lit from the front.";
  } else if (share([](const CardFrame* f) { return f->blurred; }) > kMany) {
    moment.what = "The pictures are blurred.";
    moment.film_again = "Move more slowly there, or film in more light.";
  } else if (share([](const CardFrame* f) { return f->turned; }) > kMany) {
    moment.what = "The head is turned so far that the face is hard to follow.";
    moment.film_again = "Turn that far again, slowly, and rest there for a second.";
  } else {
    moment.what = "The face does something that the head model follows badly.";
    moment.film_again = hold_it(frames, avatar, basis);
  }
  return moment;
}

std::vector<CardMoment> worst_moments(const std::vector<CardFrame>& frames, const Avatar& avatar,
                                      const ActionBasis& basis) {
  std::vector<double> around(frames.size(), 0);  // mean badness of the window about each frame
  for (std::size_t i = 0, first = 0, end = 0; i < frames.size(); ++i) {
    while (frames[first].time_s < frames[i].time_s - kWindow_s / 2) ++first;
    while (end < frames.size() && frames[end].time_s <= frames[i].time_s + kWindow_s / 2) ++end;
    for (std::size_t k = first; k < end; ++k) around[i] += frames[k].badness / double(end - first);
  }
  std::vector<CardMoment> moments;
  while (moments.size() < 3) {
    std::size_t peak = frames.size();
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const bool taken = std::ranges::any_of(moments, [&](const CardMoment& m) {
        return frames[i].time_s > m.from_s - kApart_s && frames[i].time_s < m.to_s + kApart_s;
      });
      if (!taken && around[i] >= kWorthMentioning && (peak == frames.size() || around[i] > around[peak]))
        peak = i;
    }
    if (peak == frames.size()) break;
    std::vector<const CardFrame*> there;
    for (const CardFrame& frame : frames)
      if (std::abs(frame.time_s - frames[peak].time_s) <= kWindow_s / 2) there.push_back(&frame);
    moments.push_back(describe(there, around[peak], avatar, basis));
  }
  return moments;
}

}  // namespace

Card make_card(const Capture& capture, const CameraSet& cameras, const Track& track, const SeenViews& further,
               const Avatar& avatar, const HeadModel& model, const SeenMouth& mouth) {
  const ActionBasis basis = action_basis(model);
  Card card;
  const std::vector<FrameSpan> serve = stretches_that_serve(capture);
  for (const TrackedFrame& frame : track.frames) {
    if (span_of(serve, frame.frame) < 0) continue;  // of a shot that is left out
    card.weak += frame.status == FrameStatus::weak;
    card.lost += frame.status == FrameStatus::lost;
  }
  for (const CaptureFrame& frame : capture.frames) card.refused += is_refused(frame);
  const SeenViews seen = joined(seen_views(capture, cameras, track), further);
  card.trained = int(seen.views.size());
  card.low = seen.low, card.high = seen.high;
  card.parts = avatar.parts;
  card.holds = avatar.holds;
  card.expressions = expressions(avatar, basis, mouth);
  card.mouth = mouth;
  add_view_gaps(seen, card.gaps);
  add_expression_gaps(card.expressions, card.gaps);
  card.worst = worst_moments(card_frames(capture, cameras, track), avatar, basis);
  return card;
}

Result<Card> project_card(const Project& project) {
  const auto read = read_tracked_capture(project);
  if (!read) return read.error();
  const auto& [capture, cameras, track] = *read;
  const auto avatar = read_avatar(avatar_path(project));
  if (!avatar) return avatar.error();
  const auto model = project_head_model(project.options);
  if (!model) return model.error();
  if (const auto fits = check_track_fits(track, *model); !fits) return fits.error();
  if (const auto fits = check_avatar_fits(*avatar, *model, project.folder.string()); !fits)
    return fits.error();
  const Capture trained = without_left_out(capture, project.options.train.left_out);
  return make_card(trained, cameras, track, learnt_further_views(project), *avatar, *model,
                   seen_mouth(project.folder, trained, cameras, track, *model));
}

}  // namespace likeness
