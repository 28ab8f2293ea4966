// The coarse person mask: from a face box alone, generous, since it only has to keep the person out of camera
// solves.
#include <algorithm>
#include <memory>
#include <mutex>
#include <opencv2/imgproc.hpp>

#include "core/matte/matte.h"
#include "core/track/landmarks.h"

namespace likeness {
namespace {

constexpr int kDetectionSide = 800;  // px, the longer side that the detector sees

struct CoarseState {
  explicit CoarseState(FaceDetector loaded) : detector(std::move(loaded)) {}
  std::mutex mutex;  // the detector is not thread-safe
  FaceDetector detector;
  std::vector<FaceBox>
      last;  // of the last picture with a face: heads do not vanish when a detector misses them
};

// Head ellipse with hair, neck and shoulders widening down to the lower border.
void draw_person(cv::Mat& mask, const FaceBox& box) {
  const double cx = box.x + box.width / 2, w = box.width, h = box.height;
  const int margin = int(std::lround(0.12 * w));
  cv::ellipse(
      mask,
      {cv::Point2d(cx, box.y + 0.38 * h), cv::Size2d(2 * 0.8 * w + 2 * margin, 2 * 1.0 * h + 2 * margin), 0},
      255, cv::FILLED);
  const double bottom = mask.rows + 1;
  const auto at = [](double x, double y) { return cv::Point(int(std::lround(x)), int(std::lround(y))); };
  const std::vector<cv::Point> body{at(cx - 0.75 * w, box.y + 0.75 * h),
                                    at(cx + 0.75 * w, box.y + 0.75 * h),
                                    at(cx + 2.1 * w, box.y + 1.6 * h),
                                    at(cx + 2.6 * w, std::max(bottom, box.y + 2.4 * h)),
                                    at(cx - 2.6 * w, std::max(bottom, box.y + 2.4 * h)),
                                    at(cx - 2.1 * w, box.y + 1.6 * h)};
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{body}, 255);
}

}  // namespace

Result<PersonMask> coarse_person_mask(const std::filesystem::path& predictor) {
  auto detector = FaceDetector::load(predictor);
  if (!detector) return detector.error();
  auto state = std::make_shared<CoarseState>(std::move(*detector));
  return PersonMask([state](int, const Image8& rgb) {
    Image8 mask(rgb.width, rgb.height, 1, 0);
    const double scale = std::min(1.0, double(kDetectionSide) / std::max(rgb.width, rgb.height));
    std::vector<FaceBox> boxes;
    {
      const std::lock_guard lock(state->mutex);
      boxes = scale < 1 ? state->detector.detect(resize(rgb, int(rgb.width * scale), int(rgb.height * scale)))
                        : state->detector.detect(rgb);
      for (auto& box : boxes)
        box = {box.x / scale, box.y / scale, box.width / scale, box.height / scale, box.score};
      if (boxes.empty())
        boxes = state->last;
      else
        state->last = boxes;
    }
    cv::Mat view(mask.height, mask.width, CV_8U, mask.data.data());
    for (const auto& box : boxes) draw_person(view, box);
    return mask;
  });
}

}  // namespace likeness
