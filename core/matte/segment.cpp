// The energy follows GrabCut (Rother et al. 2004) with fixed statistics instead of iterated mixtures, and the
// plate's edges taken out of the contrast term as in background cut (Sun et al. 2006).
#include "core/matte/segment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

namespace likeness {
namespace {

constexpr int kBins = 16;
constexpr float kCertain = 5.0f;  // a likelihood ratio beyond which a pixel needs no cut
constexpr float kSmoothness = 2.5f;
constexpr float kMinOfRoom = -0.9f;  // evidence for background from a room that agrees
constexpr double kContinues = 0.08;  // of the width: how far a background is assumed to continue as seen

int bin_of(const cv::Vec3b& colour) {
  return (colour[0] / (256 / kBins) * kBins + colour[1] / (256 / kBins)) * kBins + colour[2] / (256 / kBins);
}

// Blurs a histogram with [1 2 1] / 4 along each axis.
void blur(std::vector<float>& histogram) {
  for (const int stride : {1, kBins, kBins * kBins}) {
    const std::vector<float> before = histogram;
    for (int i = 0; i < kBins * kBins * kBins; ++i) {
      const int place = i / stride % kBins;
      const float lower = place > 0 ? before[std::size_t(i - stride)] : before[std::size_t(i)];
      const float upper = place + 1 < kBins ? before[std::size_t(i + stride)] : before[std::size_t(i)];
      histogram[std::size_t(i)] = 0.25f * (lower + 2 * before[std::size_t(i)] + upper);
    }
  }
}

// Person over background from the difference to the plate at one pixel.
float plate_ratio(const cv::Vec3b& pixel, const cv::Vec3b& plate, float noise) {
  float difference = 0, brightness = 0, plate_brightness = 0;
  for (int c = 0; c < 3; ++c) {
    difference = std::max(difference, std::abs(float(pixel[c]) - float(plate[c])));
    brightness += pixel[c];
    plate_brightness += plate[c];
  }
  float ratio = std::clamp(0.45f * (difference / noise - 4.5f), -2.0f, 4.0f);
  // A shadow darkens all channels alike.
  const float dimming = brightness / std::max(1.0f, plate_brightness);
  if (ratio > 0 && dimming > 0.72f && dimming < 1) {
    float tint = 0;
    for (int c = 0; c < 3; ++c) tint = std::max(tint, std::abs(float(pixel[c]) - dimming * float(plate[c])));
    if (tint < 2.5f * noise) ratio *= 0.3f;
  }
  return ratio;
}

// Log odds of an alpha; limited to fifty to one.
float log_odds(unsigned char alpha) {
  const float share = std::clamp(float(alpha) / 255, 0.02f, 0.98f);
  return std::log(share / (1 - share));
}

// How far the plate's unseen part can be predicted from what it saw beside it: 32F, 1 at its rim, less
// further in.
cv::Mat plate_continues(const Plate& plate) {
  cv::Mat distance, share;
  cv::distanceTransform(255 - plate.known, distance, cv::DIST_L2, 3);
  cv::exp(distance * (-1.0 / (kContinues * plate.known.cols)), share);
  return share;
}

// Evidence for background where a pixel looks like the plate's continuation behind the person.
float continued_ratio(const cv::Vec3b& pixel, const cv::Vec3b& filled, float share) {
  float difference = 0;
  for (int c = 0; c < 3; ++c) difference = std::max(difference, std::abs(float(pixel[c]) - float(filled[c])));
  constexpr float kLike = 18, kWeight = 4;  // of 255
  return -kWeight * share * std::exp(-difference * difference / (kLike * kLike));
}

bool is_excluded(const SegmentInput& in, int y, int x) {
  return !in.prior->excluded.empty() && in.prior->excluded.at<unsigned char>(y, x);
}

cv::Mat likelihoods(const SegmentInput& in) {
  const cv::Mat& picture = *in.picture;
  cv::Mat ratio(picture.size(), CV_32F);
  const bool rests = in.plate && !in.plate_is_room;
  const cv::Mat continues = rests ? plate_continues(*in.plate) : cv::Mat();
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      float& value = ratio.at<float>(y, x);
      if (in.prior->certain.at<unsigned char>(y, x)) {
        value = 2 * kCertain;
        continue;
      }
      if (is_excluded(in, y, x)) {
        value = -2 * kCertain;
        continue;
      }
      // A network outweighs colours and place together where it is confident.
      constexpr float kNetwork = 1.5f;
      const float opinion = in.network ? kNetwork * log_odds(in.network->at<unsigned char>(y, x)) : 0;
      const auto& pixel = picture.at<cv::Vec3b>(y, x);
      const bool below = in.lower_colours && in.prior->below.at<unsigned char>(y, x);
      const ColourModel* colours = below ? in.lower_colours : in.colours;
      const float colour = colours ? colours->ratio(pixel) : 0, place = in.prior->location.at<float>(y, x);
      if (in.plate && in.plate->known.at<unsigned char>(y, x)) {
        const float difference =
            plate_ratio(pixel, in.plate->colour.at<cv::Vec3b>(y, x), in.plate->noise.at<float>(y, x));
        // A model of the room is less accurate than a plate: its agreement says less, colour and place say
        // more.
        value = in.plate->known.at<unsigned char>(y, x) == kOfRoom
                    ? 1.1f * std::max(difference, kMinOfRoom) + 0.8f * colour + 0.8f * place
                    : 1.3f * difference + 0.4f * colour + 0.5f * place;
      } else if (in.prior->possible.at<unsigned char>(y, x)) {
        value = colour + place;
        // Texture at rest away from the body is the room's, not an arm's.
        if (in.still && place < 0) value -= 3.0f * in.still->at<float>(y, x);
        // Shoulders and arms that hardly move never uncover what is beside them.
        if (rests && below)
          value += continued_ratio(pixel, in.plate->colour.at<cv::Vec3b>(y, x), continues.at<float>(y, x));
      } else {
        // Without a plate nothing beyond the possible region is taken for person; with one, its holes out
        // there are the person's own doing.
        value = rests ? colour + 0.5f * place : -2 * kCertain;
      }
      value += opinion;
    }
  return ratio;
}

// Contrast between two neighbours less the plate's contrast there.
struct Contrast {
  const cv::Mat& picture;
  const Plate* plate;
  float beta;

  float squared(int y, int x, int v, int u) const {
    const auto &a = picture.at<cv::Vec3b>(y, x), &b = picture.at<cv::Vec3b>(v, u);
    const bool known = plate && plate->known.at<unsigned char>(y, x) && plate->known.at<unsigned char>(v, u);
    float sum = 0;
    for (int c = 0; c < 3; ++c) {
      float difference = float(a[c]) - float(b[c]);
      if (known) {
        const float own =
            float(plate->colour.at<cv::Vec3b>(y, x)[c]) - float(plate->colour.at<cv::Vec3b>(v, u)[c]);
        difference = std::abs(difference) - std::min(std::abs(difference), std::abs(own));
      }
      sum += difference * difference;
    }
    return sum;
  }
  float weight(int y, int x, int v, int u) const {
    return kSmoothness * (0.08f + 0.92f * std::exp(-beta * squared(y, x, v, u)));
  }
};

float contrast_scale(const cv::Mat& picture) {
  double sum = 0;
  std::size_t count = 0;
  for (int y = 0; y + 1 < picture.rows; y += 2)
    for (int x = 0; x + 1 < picture.cols; x += 2) {
      const auto &a = picture.at<cv::Vec3b>(y, x), &b = picture.at<cv::Vec3b>(y, x + 1),
                 &d = picture.at<cv::Vec3b>(y + 1, x);
      for (int c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]) + (a[c] - d[c]) * (a[c] - d[c]);
      count += 2;
    }
  return count && sum > 0 ? float(0.5 * double(count) / sum) : 0;
}

// Minimum cut over the pixels that are not certain; the others only influence their neighbours.
cv::Mat minimum_cut(const cv::Mat& ratio, const Contrast& contrast) {
  cv::Mat person(ratio.size(), CV_8U), node(ratio.size(), CV_32S, cv::Scalar(-1));
  int nodes = 0;
  for (int y = 0; y < ratio.rows; ++y)
    for (int x = 0; x < ratio.cols; ++x) {
      const float value = ratio.at<float>(y, x);
      person.at<unsigned char>(y, x) = value > 0 ? 255 : 0;
      if (std::abs(value) < kCertain) node.at<int>(y, x) = nodes++;
    }
  if (nodes == 0) return person;
  cv::detail::GCGraph<float> graph;
  graph.create((unsigned int)(nodes), (unsigned int)(8 * nodes));
  std::vector<float> pull(std::size_t(nodes), 0);
  for (int i = 0; i < nodes; ++i) graph.addVtx();
  constexpr std::array<std::array<int, 2>, 4> kSteps{{{1, 0}, {0, 1}, {1, 1}, {-1, 1}}};
  for (int y = 0; y < ratio.rows; ++y)
    for (int x = 0; x < ratio.cols; ++x) {
      const int own = node.at<int>(y, x);
      if (own >= 0) pull[std::size_t(own)] += ratio.at<float>(y, x);
      for (const auto& [dx, dy] : kSteps) {
        const int u = x + dx, v = y + dy;
        if (u < 0 || u >= ratio.cols || v >= ratio.rows) continue;
        const int other = node.at<int>(v, u);
        if (own < 0 && other < 0) continue;
        const float weight = contrast.weight(y, x, v, u) * (dx && dy ? 0.707f : 1.0f);
        if (own >= 0 && other >= 0)
          graph.addEdges(own, other, weight, weight);
        else if (own >= 0)
          pull[std::size_t(own)] += ratio.at<float>(v, u) > 0 ? weight : -weight;
        else
          pull[std::size_t(other)] += ratio.at<float>(y, x) > 0 ? weight : -weight;
      }
    }
  for (int i = 0; i < nodes; ++i)
    graph.addTermWeights(i, std::max(0.0f, pull[std::size_t(i)]), std::max(0.0f, -pull[std::size_t(i)]));
  graph.maxFlow();
  for (int y = 0; y < ratio.rows; ++y)
    for (int x = 0; x < ratio.cols; ++x)
      if (const int own = node.at<int>(y, x); own >= 0)
        person.at<unsigned char>(y, x) = graph.inSourceSegment(own) ? 255 : 0;
  return person;
}

// Keeps the parts that touch the certain person, and closes holes that are small or that no plate supports,
// except those painted as background.
void tidy(cv::Mat& person, const SegmentInput& in) {
  cv::Mat labels, stats, centres;
  int count = cv::connectedComponentsWithStats(person, labels, stats, centres, 8, CV_32S);
  std::vector<char> keep(std::size_t(count), 0);
  for (int y = 0; y < person.rows; ++y)
    for (int x = 0; x < person.cols; ++x)
      if (in.prior->certain.at<unsigned char>(y, x)) keep[std::size_t(labels.at<int>(y, x))] = 1;
  for (int y = 0; y < person.rows; ++y)
    for (int x = 0; x < person.cols; ++x)
      if (!keep[std::size_t(labels.at<int>(y, x))]) person.at<unsigned char>(y, x) = 0;

  const cv::Mat background = person == 0;
  count = cv::connectedComponentsWithStats(background, labels, stats, centres, 4, CV_32S);
  std::vector<int> spoken_for(std::size_t(count), 0);
  std::vector<char> said(std::size_t(count), 0);
  for (int y = 0; y < person.rows; ++y)
    for (int x = 0; x < person.cols; ++x) {
      if (is_excluded(in, y, x)) said[std::size_t(labels.at<int>(y, x))] = 1;
      if (in.plate && in.plate->known.at<unsigned char>(y, x) >= (in.plate_is_room ? kOfRoom : kSeen))
        ++spoken_for[std::size_t(labels.at<int>(y, x))];
    }
  for (int i = 1; i < count; ++i) {
    const int* s = stats.ptr<int>(i);
    const bool open = s[cv::CC_STAT_LEFT] == 0 || s[cv::CC_STAT_TOP] == 0 ||
                      s[cv::CC_STAT_LEFT] + s[cv::CC_STAT_WIDTH] == person.cols ||
                      s[cv::CC_STAT_TOP] + s[cv::CC_STAT_HEIGHT] == person.rows;
    const int area = s[cv::CC_STAT_AREA];
    if (said[std::size_t(i)]) continue;
    if (area < int(person.total() / 2000) || (!open && spoken_for[std::size_t(i)] * 2 < area))
      person.setTo(255, labels == i);
  }
}

// Local mean colour of the pixels under a mask; weight receives how many there were.
cv::Mat local_mean(const cv::Mat& picture, const cv::Mat& mask, int radius, cv::Mat& weight) {
  cv::Mat value, mask1, mask3;
  picture.convertTo(value, CV_32FC3);
  mask.convertTo(mask1, CV_32F, 1.0 / 255);
  cv::merge(std::array<cv::Mat, 3>{mask1, mask1, mask1}, mask3);
  value = value.mul(mask3);
  const cv::Size window(2 * radius + 1, 2 * radius + 1);
  cv::boxFilter(value, value, -1, window);
  cv::boxFilter(mask1, weight, -1, window);
  return value;
}

}  // namespace

ColourModel::ColourModel()
    : person_(kBins * kBins * kBins, 0.0f), background_(person_.size(), 0.0f), ratio_(person_.size(), 0.0f) {}

void ColourModel::add(const cv::Mat& picture, const cv::Mat& mask, bool person) {
  auto& histogram = person ? person_ : background_;
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      if (mask.at<unsigned char>(y, x)) histogram[std::size_t(bin_of(picture.at<cv::Vec3b>(y, x)))] += 1;
}

void ColourModel::finish() {
  std::vector<float> person = person_, background = background_;
  double person_sum = 0, background_sum = 0;
  for (float v : person) person_sum += v;
  for (float v : background) background_sum += v;
  blur(person);
  blur(background);
  for (std::size_t i = 0; i < ratio_.size(); ++i) {
    const double p = person_sum > 0 ? person[i] / person_sum : 0,
                 b = background_sum > 0 ? background[i] / background_sum : 0;
    ratio_[i] = std::clamp(float(std::log((p + 2e-5) / (b + 2e-5))), -2.5f, 2.5f);
  }
}

float ColourModel::ratio(const cv::Vec3b& colour) const { return ratio_[std::size_t(bin_of(colour))]; }

cv::Mat cut_person(const SegmentInput& input) {
  const cv::Mat ratio = likelihoods(input);
  cv::Mat person = minimum_cut(ratio, {*input.picture, input.plate, contrast_scale(*input.picture)});
  tidy(person, input);
  return person;
}

cv::Mat soften(const cv::Mat& picture, const cv::Mat& person, const Plate* plate, int radius) {
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
  // The picture's edge is not a boundary of the person.
  cv::Mat inner, outer, inner_weight, outer_weight, blurred;
  cv::erode(person, inner, disc);
  cv::dilate(person, outer, disc);
  const cv::Mat inside = local_mean(picture, inner, 3 * radius, inner_weight);
  const cv::Mat outside = local_mean(picture, 255 - outer, 3 * radius, outer_weight);
  cv::GaussianBlur(person, blurred, {0, 0}, 0.4 * radius);
  cv::Mat alpha = person.clone();
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      if (inner.at<unsigned char>(y, x) || !outer.at<unsigned char>(y, x)) continue;
      const float prior = float(blurred.at<unsigned char>(y, x)) / 255;
      float mixed = prior, trust = 0;
      const float wi = inner_weight.at<float>(y, x), wo = outer_weight.at<float>(y, x);
      const bool known = plate && plate->known.at<unsigned char>(y, x);
      if (wi > 0.01f && (known || wo > 0.01f)) {
        const cv::Vec3f front = inside.at<cv::Vec3f>(y, x) / wi;
        const cv::Vec3f back = known ? cv::Vec3f(plate->colour.at<cv::Vec3b>(y, x))
                                     : cv::Vec3f(outside.at<cv::Vec3f>(y, x) / wo);
        const cv::Vec3f axis = front - back, offset = cv::Vec3f(picture.at<cv::Vec3b>(y, x)) - back;
        const float length = axis.dot(axis);
        mixed = std::clamp(offset.dot(axis) / std::max(1.0f, length), 0.0f, 1.0f);
        // Colours that differ by less than about 25 of 255 do not separate person from background.
        trust = length / (length + 25.0f * 25.0f);
      }
      // Nothing far outside the cut turns solid and nothing deep inside vanishes.
      mixed = std::clamp(mixed, prior - 0.6f, prior + 0.6f);
      alpha.at<unsigned char>(y, x) =
          cv::saturate_cast<unsigned char>(255 * (trust * mixed + (1 - trust) * prior));
    }
  return alpha;
}

cv::Mat soften_by_network(const cv::Mat& network, const cv::Mat& person, int radius) {
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
  cv::Mat inner, outer, alpha = person.clone();
  cv::erode(person, inner, disc);
  cv::dilate(person, outer, disc);
  network.copyTo(alpha, outer & (255 - inner));
  return alpha;
}

}  // namespace likeness
