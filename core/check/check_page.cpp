// The page's layout, from top to bottom: see check_page.h.
#include "core/check/check_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/image/page_canvas.h"
#include "core/video/decode.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 1240, kMargin = 50, kHighest = 6000;   // px
constexpr int kLabels = 190;                                  // px, left of the curves
constexpr int kThumb = 150, kSample = 216;                    // px, sides of pictures
constexpr double kYawSpan = 65, kPitchSpan = 35, kCell = 10;  // degrees

struct Page {
  PageCanvas canvas{kWidth, kHighest};
  const ClipMeasures& clip;
  const CaptureVerdict& verdict;
  std::map<int, Image8> pictures;  // by frame
  int y = kMargin;                 // where the next part begins

  double duration() const { return std::max(0.1, clip.duration_s); }
  double x_of(double time_s) const {
    const double share = std::clamp(time_s / duration(), 0.0, 1.0);
    return kMargin + kLabels + share * (kWidth - 2 * kMargin - kLabels);
  }
  void heading(std::string_view words) {
    canvas.text(kMargin, y, words, {21, kInk, true});
    y += 36;
  }
};

PageColour colour_of(Verdict verdict) {
  return verdict == Verdict::ready ? kGood : verdict == Verdict::usable ? kFair : kBad;
}

// -- Head

void draw_head(Page& page, const std::string& name) {
  const int height = 64, width = kWidth - 2 * kMargin;
  page.canvas.fill({kMargin, page.y, width, height}, colour_of(page.verdict.verdict));
  page.canvas.text(kMargin + 20, page.y + 21, verdict_words(page.verdict), {24, kWhite, true});
  page.y += height + 18;
  const auto faces = std::ranges::count_if(page.clip.looks, [](const Look& l) { return l.face.has_value(); });
  const std::size_t looks = std::max<std::size_t>(1, page.clip.looks.size());
  page.y = page.canvas.paragraph(
      kMargin, page.y, width,
      fmt::format(
          "{}: {:.1f} s, {} x {} px, {:.0f} frames a second; a face in {:.0f} % of {} pictures looked "
          "at.",
          name, page.clip.duration_s, page.clip.info.width, page.clip.info.height,
          page.clip.info.frames_per_second, 100.0 * double(faces) / double(looks), page.clip.looks.size()));
  page.y += 22;
}

// What the camera does, how far the mask is trusted, which parts serve: a sentence each, and the evidence.
void draw_facts(Page& page) {
  const int width = kWidth - 2 * kMargin - kLabels;
  const auto line = [&](std::string_view label, const std::string& words, const std::string& evidence) {
    page.canvas.text(kMargin, page.y, label, {15, kInk, true});
    page.y = page.canvas.paragraph(kMargin + kLabels, page.y, width, words);
    if (!evidence.empty())
      page.y = page.canvas.paragraph(kMargin + kLabels, page.y, width, evidence, {14, kPale});
    page.y += 8;
  };
  const ClipFacts facts = clip_facts(page.clip);
  line("The camera", camera_sentence(facts.camera), facts.camera.evidence);
  line("The mask", mask_sentence(facts.mask), "");
  line("What serves", parts_sentence(facts.parts), "");
  page.y += 14;
}

// -- What happens when

// One curve over time: value(look), clipped to [low, high]; looks without a face interrupt it.
template <class F>
void draw_course(Page& page, std::string_view label, double low, double high, F value) {
  constexpr int kHeight = 44;
  const int left = kMargin + kLabels, width = kWidth - 2 * kMargin - kLabels;
  page.canvas.text(kMargin, page.y + 14, label, {15});
  page.canvas.frame({left, page.y, width, kHeight}, kRule);
  const Look* before = nullptr;
  double before_y = 0;
  for (const Look& look : page.clip.looks) {
    const std::optional<double> v = value(look);
    if (!v) {
      before = nullptr;
      continue;
    }
    const double share = std::clamp((*v - low) / (high - low), 0.0, 1.0);
    const double at = page.y + kHeight - 3 - share * (kHeight - 6);
    if (before) page.canvas.line(page.x_of(before->time_s), before_y, page.x_of(look.time_s), at, kCourse, 2);
    before = &look;
    before_y = at;
  }
  page.y += kHeight + 8;
}

void draw_faces(Page& page) {
  constexpr int kHeight = 18;
  page.canvas.text(kMargin, page.y + 1, "face found", {15});
  const double half = page.clip.looks.size() > 1 ? 0.5 * page.duration() / double(page.clip.looks.size())
                                                 : 0.5 * page.duration();
  for (const Look& look : page.clip.looks) {
    const int from = int(page.x_of(look.time_s - half)), to = int(std::ceil(page.x_of(look.time_s + half)));
    page.canvas.fill({from, page.y, to - from, kHeight}, !look.face         ? kBad
                                                         : look.second_face ? kFair
                                                                            : kGood);
  }
  page.y += kHeight + 10;
}

void draw_stretches(Page& page) {
  constexpr int kHeight = 18;
  for (const Remark& remark : page.verdict.remarks) {
    std::string name(fault_name(remark.fault));
    std::ranges::replace(name, '_', ' ');
    page.canvas.text(kMargin, page.y + 1, name, {15, remark.grave ? kBad : kInk});
    const int from = int(page.x_of(remark.from_s)), to = int(std::ceil(page.x_of(remark.to_s)));
    page.canvas.fill({kMargin + kLabels, page.y, kWidth - 2 * kMargin - kLabels, kHeight}, {244, 245, 247});
    page.canvas.fill({from, page.y, std::max(4, to - from), kHeight}, remark.grave ? kBad : kFair);
    page.y += kHeight + 6;
  }
}

void draw_seconds(Page& page) {
  double step = 1;
  for (const double wider : {2.0, 5.0, 10.0, 30.0, 60.0, 300.0, 600.0, 1800.0, 3600.0})
    if (page.duration() / step > 12) step = wider;
  for (double t = 0; t <= page.duration() + 1e-9; t += step) {
    const int x = int(std::lround(page.x_of(t)));
    page.canvas.line(x, page.y, x, page.y + 6, kPale);
    const std::string words = fmt::format("{:.0f} s", t);
    page.canvas.text(x - page.canvas.text_width(words, {14}) / 2, page.y + 10, words, {14, kPale});
  }
  page.y += 46;
}

void draw_timeline(Page& page) {
  page.heading("What happens when");
  draw_faces(page);
  draw_course(page, "sharpness", 0, 400,
              [](const Look& l) { return l.face ? std::optional(l.sharpness) : std::nullopt; });
  draw_course(page, "light on the face", 0, 255,
              [](const Look& l) { return l.face ? std::optional(l.level) : std::nullopt; });
  draw_course(page, "turned aside", -kYawSpan, kYawSpan,
              [](const Look& l) { return l.posed ? std::optional(l.yaw_deg) : std::nullopt; });
  draw_course(page, "up and down", -kPitchSpan, kPitchSpan,
              [](const Look& l) { return l.posed ? std::optional(l.pitch_deg) : std::nullopt; });
  draw_stretches(page);
  draw_seconds(page);
}

// -- Angles and expressions, side by side

void draw_angles(Page& page, int x, int top) {
  const int columns = int(2 * kYawSpan / kCell), rows = int(2 * kPitchSpan / kCell), cell = 38;
  std::vector<int> count(std::size_t(columns * rows), 0);
  for (const Look& look : page.clip.looks) {
    if (!look.posed) continue;
    const int c = std::clamp(int((look.yaw_deg + kYawSpan) / kCell), 0, columns - 1),
              r = std::clamp(int((kPitchSpan - look.pitch_deg) / kCell), 0, rows - 1);
    ++count[std::size_t(r * columns + c)];
  }
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const int n = count[std::size_t(r * columns + c)];
      // A second's worth of looks covers a cell well.
      const double share = std::min(1.0, n / 5.0);
      PageColour colour{};
      for (std::size_t k = 0; k < 3; ++k)
        colour[k] = std::uint8_t(n == 0 ? 246 : 225 + share * (double(kGood[k]) - 225));
      page.canvas.fill({x + c * cell, top + r * cell, cell - 2, cell - 2}, colour);
      if (n > 0) {
        const std::string words = std::to_string(n);
        const PageText how{13, share > 0.6 ? kWhite : kInk};
        page.canvas.text(x + c * cell + (cell - 2 - page.canvas.text_width(words, how)) / 2,
                         top + r * cell + 12, words, how);
      }
    }
  const int below = top + rows * cell + 6, width = columns * cell;
  page.canvas.text(x, below, fmt::format("{:.0f} to the right", kYawSpan), {14, kPale});
  const std::string left = fmt::format("{:.0f} to the left", kYawSpan);
  page.canvas.text(x + width - page.canvas.text_width(left, {14}), below, left, {14, kPale});
  page.canvas.text(x + width / 2 - page.canvas.text_width("from the front", {14}) / 2, below,
                   "from the front", {14, kPale});
}

void draw_key_expressions(Page& page, int x, int top, int width) {
  constexpr int kLabel = 190, kHeight = 22;
  int y = top + 6;
  for (const KeyExpressionShown& expression : key_expressions_shown(page.clip)) {
    const bool enough = expression.range >= expression.needed;
    page.canvas.text(x, y + 3, expression.words, {15});
    const int left = x + kLabel, room = width - kLabel;
    page.canvas.fill({left, y, room, kHeight}, {244, 245, 247});
    page.canvas.fill({left, y, int(room * std::clamp(expression.range, 0.0, 1.0)), kHeight},
                     enough ? kGood : kFair);
    const int mark = left + int(room * expression.needed);
    page.canvas.line(mark, y - 4, mark, y + kHeight + 3, kInk, 2);
    y += kHeight + 20;
  }
  page.canvas.text(x + kLabel, y, "from the mark on, it counts as shown", {14, kPale});
}

void draw_coverage(Page& page) {
  const int columns = int(2 * kYawSpan / kCell) * 38, expressions_x = kMargin + columns + 60;
  const int top = page.y;
  page.canvas.text(kMargin, top, "Angles seen (pictures per field of 10 degrees)", {21, kInk, true});
  page.canvas.text(expressions_x, top, "Expressions shown", {21, kInk, true});
  draw_angles(page, kMargin, top + 38);
  draw_key_expressions(page, expressions_x, top + 38, kWidth - kMargin - expressions_x);
  page.y = top + 38 + int(2 * kPitchSpan / kCell) * 38 + 50;
}

// -- Remarks and sample pictures

void draw_remarks(Page& page) {
  page.heading(page.verdict.remarks.empty() ? "No problems found" : "Remarks");
  for (const Remark& remark : page.verdict.remarks) {
    const int top = page.y, text_x = kMargin + kThumb + 24, width = kWidth - kMargin - text_x;
    const int frame = remark_frame(page.clip, remark);
    if (const auto found = page.pictures.find(frame); found != page.pictures.end())
      page.canvas.picture({kMargin, top, kThumb, kThumb}, found->second);
    page.canvas.frame({kMargin, top, kThumb, kThumb}, kRule);
    page.canvas.text(
        text_x, top,
        fmt::format("{:.0f} to {:.0f} s; the picture: frame {}", remark.from_s, remark.to_s, frame),
        {14, kPale});
    int y =
        page.canvas.paragraph(text_x, top + 26, width, remark.what, {18, remark.grave ? kBad : kInk, true});
    y = page.canvas.paragraph(text_x, y + 4, width, remark.remedy, {17});
    page.y = std::max(y, top + kThumb) + 20;
  }
}

struct Sample {
  std::string_view words;
  int frame = -1;
};

template <class F>
Sample most(const ClipMeasures& clip, std::string_view words, F value) {
  Sample sample{words, -1};
  double best = -1e9;
  for (const Look& look : clip.looks)
    if (look.posed && value(look) > best) best = value(look), sample.frame = look.frame;
  return sample;
}

std::vector<Sample> samples_of(const ClipMeasures& clip) {
  const auto expression = [](KeyExpression d) {
    return [d](const Look& l) { return l.expressions[std::size_t(d)]; };
  };
  return {most(clip, "furthest to the right", [](const Look& l) { return -l.yaw_deg; }),
          most(clip, "most frontal", [](const Look& l) { return -std::hypot(l.yaw_deg, l.pitch_deg); }),
          most(clip, "furthest to the left", [](const Look& l) { return l.yaw_deg; }),
          most(clip, "mouth most open", expression(KeyExpression::open_mouth)),
          most(clip, "widest smile", expression(KeyExpression::smile))};
}

void draw_samples(Page& page) {
  const std::vector<Sample> samples = samples_of(page.clip);
  if (samples.front().frame < 0) return;
  page.heading("What the clip shows");
  const int step = (kWidth - 2 * kMargin) / int(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const int x = kMargin + int(i) * step;
    if (const auto found = page.pictures.find(samples[i].frame); found != page.pictures.end())
      page.canvas.picture({x, page.y, kSample, kSample}, found->second);
    page.canvas.text(x, page.y + kSample + 8, samples[i].words, {15});
    page.canvas.text(x, page.y + kSample + 30, fmt::format("frame {}", samples[i].frame), {14, kPale});
  }
  page.y += kSample + 70;
}

// Head and shoulders where a face is known, the whole picture otherwise.
Image8 cut_sample(const Image8& rgb, const Look* look) {
  if (!look || !look->face) return rgb;
  const FaceBox& f = *look->face;
  const int side = int(2.4 * std::max(f.width, f.height));
  return crop(rgb, int(f.x + f.width / 2) - side / 2, int(f.y + 0.45 * f.height) - side / 2, side, side);
}

Result<std::map<int, Image8>> read_pictures(const fs::path& video, const ClipMeasures& clip,
                                            const std::set<int>& wanted, const Progress& progress,
                                            std::stop_token stop) {
  std::map<int, Image8> pictures;
  auto reader = VideoReader::open(video, VideoPixels::rgb, VideoFrames::sampled);
  if (!reader) return reader.error();
  reader->show_part(clip.film);
  while (pictures.size() < wanted.size()) {
    if (stop.stop_requested()) return cancelled_error();
    const auto frame = reader->next();
    if (!frame) return frame.error();
    if (!*frame) break;
    const VideoFrame& f = **frame;
    if (!wanted.contains(f.index)) continue;
    const auto look = std::ranges::find(clip.looks, f.index, &Look::frame);
    pictures[f.index] = cut_sample(f.rgb, look == clip.looks.end() ? nullptr : &*look);
    progress.report(double(pictures.size()) / double(wanted.size()), fmt::format("frame {}", f.index));
  }
  return pictures;
}

}  // namespace

int remark_frame(const ClipMeasures& measures, const Remark& remark) {
  const double middle = 0.5 * (remark.from_s + remark.to_s);
  int frame = -1;
  double nearest = 1e18;
  for (const Look& look : measures.looks) {
    // A look that does not show the fault counts only if none does.
    const double away = std::abs(look.time_s - middle) + (shows_fault(look, remark.fault) ? 0 : 1e9);
    if (away < nearest) nearest = away, frame = look.frame;
  }
  return frame;
}

Result<Image8> draw_check_page(const fs::path& video, const ClipMeasures& measures,
                               const CaptureVerdict& verdict, const Progress& progress,
                               std::stop_token stop) {
  std::set<int> wanted;
  for (const Remark& remark : verdict.remarks) wanted.insert(remark_frame(measures, remark));
  for (const Sample& sample : samples_of(measures)) wanted.insert(sample.frame);
  wanted.erase(-1);
  auto pictures = read_pictures(video, measures, wanted, progress, stop);
  if (!pictures) return pictures.error();
  Page page{.clip = measures, .verdict = verdict, .pictures = std::move(*pictures)};
  draw_head(page, video.filename().string());
  draw_facts(page);
  draw_timeline(page);
  draw_coverage(page);
  draw_remarks(page);
  draw_samples(page);
  progress.report(1);
  return page.canvas.finish(page.y + kMargin / 2);
}

}  // namespace likeness
