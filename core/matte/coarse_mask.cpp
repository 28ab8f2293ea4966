// The coarse person mask: a figure drawn below a face box, and what a person network sees round that face. It
// only has to keep the person out of camera solves, and is no larger than needed: the background close beside
// the head has the most parallax.
#include "core/matte/coarse_mask.h"

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/face/landmarks.h"
#include "core/matte/person_network.h"
#include "core/matte/person_share.h"

namespace likeness {
namespace {

constexpr int kDetectionSide = 800;  // px, the longer side that the detector sees
constexpr double kSureScore = 0.4;   // of the detector; below it, chance patterns are common
constexpr double kSameFace = 0.3;    // shared area over joint area of a face found twice
// Of the network's share, in widths of a face: a rim beyond the outline, holes that are none.
constexpr double kSoftRim = 0.12, kClosedHole = 0.5;
constexpr unsigned char kMaybePerson = 64;  // of 255

struct CoarseState {
  explicit CoarseState(FaceDetector loaded) : detector(std::move(loaded)) {}
  std::mutex mutex;  // the detector is not thread-safe
  FaceDetector detector;
  std::vector<FaceBox> last;    // accepted in the last picture that had any
  std::vector<FaceBox> unsure;  // not accepted in the last picture
  int frame = -1;               // the last one's number
};

bool is_among(const FaceBox& face, const std::vector<FaceBox>& others) {
  return std::ranges::any_of(others, [&](const FaceBox& other) {
    const double w = std::min(face.x + face.width, other.x + other.width) - std::max(face.x, other.x),
                 h = std::min(face.y + face.height, other.y + other.height) - std::max(face.y, other.y);
    const double shared = std::max(0.0, w) * std::max(0.0, h);
    return shared > kSameFace * (face.width * face.height + other.width * other.height - shared);
  });
}

// The faces of this picture that are certain, or were there before.
std::vector<FaceBox> believed(CoarseState& state, const std::vector<FaceBox>& found, Pictures pictures) {
  std::vector<FaceBox> faces, unsure;
  for (const FaceBox& face : found) {
    const bool known =
        pictures == Pictures::in_sequence && (is_among(face, state.last) || is_among(face, state.unsure));
    (face.score >= kSureScore || known ? faces : unsure).push_back(face);
  }
  state.unsure = std::move(unsure);
  if (pictures == Pictures::single) return faces;
  if (faces.empty()) return state.last;  // heads do not vanish when a detector misses them
  state.last = faces;
  return faces;
}

struct Figure {
  double head_width, head_height;  // half axes of head and hair, in widths and heights of the face
  // Half widths down the body, in face widths, at heights in face heights below the box's upper edge.
  std::array<std::pair<double, double>, 4> body;
};
// Some 10 % larger than an upright adult's: a network looks, too, and adds what reaches further.
constexpr Figure kUsualFigure{1.44, 1.85, {{{0.55, 0.8}, {0.7, 1.2}, {1.8, 1.6}, {2.4, 2.1}}}};
// Where no network looks: hardly anybody is broader, has wider hair, or turns and bows further out of it. A
// shoulder left out would pass for the background, and its sway for the camera's.
constexpr Figure kLargestFigure{1.95, 2.2, {{{0.8, 0.8}, {1.3, 1.05}, {2.6, 1.5}, {3.2, 2.0}}}};

// Head ellipse with hair, neck, and shoulders that slope down to the lower border. The detector's box spans
// about the brows to the chin and is as wide as the face.
void draw_person(cv::Mat& mask, const FaceBox& box, const Figure& figure) {
  const double cx = box.x + box.width / 2, w = box.width, h = box.height;
  cv::ellipse(
      mask, {cv::Point2d(cx, box.y + 0.36 * h), cv::Size2d(figure.head_width * w, figure.head_height * h), 0},
      255, cv::FILLED);
  const double bottom = std::max(mask.rows + 1.0, box.y + 2.4 * h);
  const auto at = [](double x, double y) { return cv::Point(int(std::lround(x)), int(std::lround(y))); };
  std::vector<cv::Point> body;
  for (const auto& [half, down] : figure.body) body.push_back(at(cx + half * w, box.y + down * h));
  const double lowest = figure.body.back().first + 0.1;
  body.push_back(at(cx + lowest * w, bottom));
  body.push_back(at(cx - lowest * w, bottom));
  for (auto it = std::rbegin(figure.body); it != std::rend(figure.body); ++it)
    body.push_back(at(cx - it->first * w, box.y + it->second * h));
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{body}, 255);
}

// Adds what the network sees of the person with this face: strands and fingers leave its outline by a few
// hundredths of a head. Whether it sees them.
bool add_seen_person(cv::Mat& mask, const PersonNetwork& network, const Image8& rgb, const FaceBox& box) {
  const auto seen = network.share_about(rgb, box, Looks::once);
  if (!seen) return false;
  const cv::Mat share(seen->height, seen->width, CV_8U, const_cast<std::uint8_t*>(seen->data.data()));
  cv::Mat face(share.size(), CV_8U, cv::Scalar(0));
  cv::ellipse(face,
              {cv::Point2d(box.x + box.width / 2, box.y + box.height / 2),
               cv::Size2d(0.8 * box.width, 0.8 * box.height), 0},
              255, cv::FILLED);
  const cv::Mat own = persons_own_share(share, face, kClosedHole * box.width);
  if (own.empty()) return false;
  const int radius = std::max(2, int(std::lround(kSoftRim * box.width)));
  cv::Mat grown;
  cv::dilate(own > kMaybePerson, grown,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1}));
  mask |= grown;
  return true;
}

}  // namespace

Result<PersonMask> coarse_person_mask(const std::filesystem::path& predictor, Pictures pictures,
                                      const std::filesystem::path& person_network,
                                      std::shared_ptr<PersonSightings> sightings) {
  auto detector = FaceDetector::load(predictor);
  if (!detector) return detector.error();
  auto network = chosen_person_network(person_network);
  if (!network) return network.error();
  if (sightings) sightings->network = *network != nullptr;
  auto state = std::make_shared<CoarseState>(std::move(*detector));
  return PersonMask([state, pictures, network = std::move(*network), sightings](int frame,
                                                                                const Image8& rgb) {
    Image8 mask(rgb.width, rgb.height, 1, 0);
    const double scale = std::min(1.0, double(kDetectionSide) / std::max(rgb.width, rgb.height));
    std::vector<FaceBox> boxes;
    {
      const std::lock_guard lock(state->mutex);
      boxes = scale < 1 ? state->detector.detect(resize(rgb, int(rgb.width * scale), int(rgb.height * scale)))
                        : state->detector.detect(rgb);
      for (auto& box : boxes)
        box = {box.x / scale, box.y / scale, box.width / scale, box.height / scale, box.score};
      // The clip begins again: faces at its end say nothing.
      if (frame < state->frame) state->last.clear(), state->unsure.clear();
      state->frame = frame;
      boxes = believed(*state, boxes, pictures);
    }
    cv::Mat view(mask.height, mask.width, CV_8U, mask.data.data());
    for (const auto& box : boxes) {
      const bool seen = network && add_seen_person(view, *network, rgb, box);
      draw_person(view, box, network ? kUsualFigure : kLargestFigure);
      if (sightings) ++sightings->faces, sightings->seen += seen;
    }
    return mask;
  });
}

}  // namespace likeness
