// Intervals between two keyframes are buffered, so that points come from the keyframe before and the one
// after.
#include "core/camera/resect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/base/align_points.h"
#include "core/base/rigid.h"
#include "core/video/decode.h"
#include "core/video/grey_pictures.h"

namespace likeness {
namespace {

constexpr std::size_t kMostPoints = 300;    // per keyframe: more cost time, not error
constexpr std::size_t kMostBuffered = 240;  // frames between two keyframes
constexpr std::size_t kLeastInliers = 15;
constexpr double kInlierPx = 2.0, kMostRmsPx = 1.5;

struct Correspondences {
  std::vector<cv::Point2f> pixels;
  std::vector<cv::Point3f> points;
};

struct Buffered {
  int frame = 0;
  cv::Mat grey;
  Correspondences seen;
};

// Follows a keyframe's points through frames in the order given; what passes the return check is added to
// each.
void follow_points(const SolvedKeyframe& keyframe, const cv::Mat& key_grey, std::vector<Buffered*> frames,
                   const std::stop_token& stop) {
  std::vector<cv::Point2f> anchor, now;
  std::vector<cv::Point3f> points;
  const std::size_t stride = std::max<std::size_t>(1, keyframe.pixels.size() / kMostPoints);
  for (std::size_t i = 0; i < keyframe.pixels.size(); i += stride) {
    // OpenCV counts from the centre of the first pixel, we from its corner.
    anchor.emplace_back(float(keyframe.pixels[i].x() - 0.5), float(keyframe.pixels[i].y() - 0.5));
    points.emplace_back(float(keyframe.points[i].x()), float(keyframe.points[i].y()),
                        float(keyframe.points[i].z()));
  }
  now = anchor;
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);
  for (Buffered* frame : frames) {
    if (anchor.size() < 4 || stop.stop_requested()) return;
    std::vector<cv::Point2f> next = now, back = anchor;
    std::vector<unsigned char> found, returned;
    std::vector<float> error;
    cv::calcOpticalFlowPyrLK(key_grey, frame->grey, anchor, next, found, error, {21, 21}, 3, until,
                             cv::OPTFLOW_USE_INITIAL_FLOW);
    cv::calcOpticalFlowPyrLK(frame->grey, key_grey, next, back, returned, error, {21, 21}, 3, until,
                             cv::OPTFLOW_USE_INITIAL_FLOW);
    for (std::size_t i = 0; i < next.size(); ++i) {
      // A point lost for one frame keeps its last place as the guess for the next.
      if (!found[i] || !returned[i] || cv::norm(back[i] - anchor[i]) > 0.5) continue;
      now[i] = next[i];
      frame->seen.pixels.emplace_back(next[i].x + 0.5f, next[i].y + 0.5f);
      frame->seen.points.push_back(points[i]);
    }
  }
}

// Camera pose from 2-D to 3-D correspondences; nullopt when the gate refuses it.
std::optional<Pose> solve_pose(const Correspondences& seen, const Intrinsics& k, const Pose& guess) {
  if (seen.points.size() < kLeastInliers) return std::nullopt;
  const cv::Matx33d matrix(k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1);
  const cv::Vec4d distortion(k.k1, k.k2, k.p1, k.p2);
  const Vec3d turn_vector = vector_from_turn(guess.linear()), shift = guess.translation();
  cv::Mat rotation = (cv::Mat_<double>(3, 1) << turn_vector.x(), turn_vector.y(), turn_vector.z());
  cv::Mat translation = (cv::Mat_<double>(3, 1) << shift.x(), shift.y(), shift.z());
  std::vector<int> inliers;
  if (!cv::solvePnPRansac(seen.points, seen.pixels, matrix, distortion, rotation, translation, true, 100,
                          float(kInlierPx), 0.999, inliers))
    return std::nullopt;
  if (inliers.size() < std::max(kLeastInliers, seen.points.size() * 2 / 5)) return std::nullopt;
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2f> pixels, projected;
  for (int i : inliers)
    points.push_back(seen.points[std::size_t(i)]), pixels.push_back(seen.pixels[std::size_t(i)]);
  cv::solvePnPRefineLM(points, pixels, matrix, distortion, rotation, translation);
  cv::projectPoints(points, rotation, translation, matrix, distortion, projected);
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    sum += cv::norm(projected[i] - pixels[i]) * cv::norm(projected[i] - pixels[i]);
  if (!(std::sqrt(sum / double(points.size())) <= kMostRmsPx)) return std::nullopt;
  const Vec3d vector(rotation.at<double>(0), rotation.at<double>(1), rotation.at<double>(2));
  Pose pose = Pose::Identity();
  if (vector.norm() > 0) pose.linear() = rotation_about(vector.normalized(), vector.norm());
  pose.translation() = Vec3d(translation.at<double>(0), translation.at<double>(1), translation.at<double>(2));
  return pose;
}

// Everything between keyframe `before` and keyframe `after`; either may be missing. Ends early on stop.
void solve_interval(const SolvedKeyframe* before, const cv::Mat& before_grey, const SolvedKeyframe* after,
                    const cv::Mat& after_grey, std::vector<Buffered>& buffered, const Intrinsics& small,
                    std::vector<Camera>& out, const std::stop_token& stop) {
  std::vector<Buffered*> order;
  for (auto& frame : buffered) order.push_back(&frame);
  if (before) follow_points(*before, before_grey, order, stop);
  if (after) {
    std::reverse(order.begin(), order.end());
    follow_points(*after, after_grey, order, stop);
  }
  Pose guess = before ? before->cam_from_world : after ? after->cam_from_world : Pose::Identity();
  for (auto& frame : buffered) {
    if (stop.stop_requested()) return;
    const auto pose = solve_pose(frame.seen, small, guess);
    if (!pose) continue;
    guess = *pose;
    out.push_back({frame.frame, {}, *pose});
  }
  buffered.clear();
}

// The needed frames one after the other, ascending; nullopt after the last.
struct FollowedFrame {
  int frame = 0;
  cv::Mat grey;
};
using FollowedFrames = std::function<Result<std::optional<FollowedFrame>>()>;

cv::Mat to_mat(const Image8& grey) {
  return cv::Mat(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.data.data())).clone();
}

FollowedFrames decoding_source(VideoReader& reader, const Intrinsics& small, const std::set<int>& needed,
                               const std::stop_token& stop) {
  return [&reader, &small, &needed, &stop]() -> Result<std::optional<FollowedFrame>> {
    while (true) {
      if (stop.stop_requested()) return cancelled_error();
      auto next = reader.next();
      if (!next) return next.error();
      if (!next->has_value() || (**next).index > *needed.rbegin()) return std::optional<FollowedFrame>();
      const VideoFrame& frame = **next;
      if (!needed.contains(frame.index)) continue;
      return std::optional(
          FollowedFrame{frame.index, to_mat(followed_picture(frame.rgb, small.width, small.height))});
    }
  };
}

// From kept pictures, where they are of this video and size and none is missing.
std::optional<FollowedFrames> kept_source(const std::filesystem::path& video,
                                          const std::filesystem::path& kept, const Intrinsics& small,
                                          const std::set<int>& needed) {
  if (kept.empty()) return std::nullopt;
  auto opened = GreyPictureReader::open(kept);
  if (!opened) return std::nullopt;
  const GreyPictures& about = opened->about();
  const auto video_hash = hash_video(video);
  if (!video_hash || about.inputs != *video_hash || about.width != small.width ||
      about.height != small.height || !std::ranges::includes(about.frames, needed))
    return std::nullopt;
  const auto reader = std::make_shared<GreyPictureReader>(std::move(*opened));
  return [reader, &needed, at = std::size_t(0)]() mutable -> Result<std::optional<FollowedFrame>> {
    const std::vector<int>& frames = reader->about().frames;
    for (; at < frames.size() && frames[at] <= *needed.rbegin(); ++at) {
      auto picture = reader->next();
      if (!picture) return Error{ErrorCode::io, picture.error().what, picture.error().fix, ""};
      if (!needed.contains(frames[at])) continue;
      return std::optional(FollowedFrame{frames[at++], to_mat(*picture)});
    }
    return std::optional<FollowedFrame>();
  };
}

Result<std::vector<Camera>> resect(const FollowedFrames& frames, const std::filesystem::path& video,
                                   const std::vector<SolvedKeyframe>& keyframes, const Intrinsics& small,
                                   int last, const Progress& progress, const std::stop_token& stop) {
  std::vector<Camera> solved;
  std::map<int, const SolvedKeyframe*> by_frame;
  for (const auto& keyframe : keyframes) by_frame[keyframe.frame] = &keyframe;
  const SolvedKeyframe* before = nullptr;
  cv::Mat before_grey;
  std::vector<Buffered> buffered;
  try {
    for (;;) {
      if (stop.stop_requested()) return cancelled_error();
      auto next = frames();
      if (!next) return next.error();
      if (!next->has_value()) break;
      const auto& [frame, grey] = **next;
      const auto keyframe = by_frame.find(frame);
      if (keyframe == by_frame.end()) {
        buffered.push_back({frame, grey, {}});
        if (buffered.size() >= kMostBuffered && before)
          solve_interval(before, before_grey, nullptr, {}, buffered, small, solved, stop);
        else if (buffered.size() >= kMostBuffered)
          buffered.erase(buffered.begin());  // too long before the first keyframe to be reached from it
      } else {
        solve_interval(before, before_grey, keyframe->second, grey, buffered, small, solved, stop);
        before = keyframe->second;
        before_grey = grey;
      }
      progress.report(double(frame) / std::max(1, last), fmt::format("frame {}", frame));
    }
    solve_interval(before, before_grey, nullptr, {}, buffered, small, solved, stop);
  } catch (const cv::Exception& fault) {
    if (fault.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return Error{ErrorCode::failed,
                 fmt::format("The cameras between keyframes could not be found: {}.", fault.what()),
                 "Convert the video to H.264 (`ffmpeg -i VIDEO out.mp4`) and try again.", video.string()};
  }
  if (stop.stop_requested()) return cancelled_error();
  progress.report(1);
  return solved;
}

}  // namespace

std::vector<SolvedKeyframe> keyframes_of(const ColmapModel& model) {
  std::vector<SolvedKeyframe> keyframes;
  for (const auto& image : model.images) {
    SolvedKeyframe keyframe{std::atoi(image.name.c_str()), image.cam_from_world, {}, {}};
    for (const auto& seen : image.observations) {
      const auto point = model.points.find(seen.point);
      // Points seen once more than the two views that made them are far less often wrong.
      if (point == model.points.end() || point->second.views < 3 || point->second.error_px > 1.5) continue;
      keyframe.pixels.push_back(seen.pixel);
      keyframe.points.push_back(point->second.position);
    }
    keyframes.push_back(std::move(keyframe));
  }
  std::sort(keyframes.begin(), keyframes.end(),
            [](const SolvedKeyframe& a, const SolvedKeyframe& b) { return a.frame < b.frame; });
  return keyframes;
}

Image8 followed_picture(const Image8& rgb, int width, int height) {
  // OpenCV has no type for pixels that are only read.
  const cv::Mat source(rgb.height, rgb.width, CV_8UC3, const_cast<std::uint8_t*>(rgb.data.data()));
  cv::Mat reduced;
  cv::resize(source, reduced, {width, height}, 0, 0, width > source.cols ? cv::INTER_LINEAR : cv::INTER_AREA);
  Image8 grey(width, height, 1);
  cv::Mat view(height, width, CV_8UC1, grey.data.data());
  cv::cvtColor(reduced, view, cv::COLOR_RGB2GRAY);
  return grey;
}

Result<std::vector<Camera>> resect_frames(const std::filesystem::path& video, const PixelRect& film,
                                          const std::vector<SolvedKeyframe>& keyframes,
                                          const Intrinsics& small, const std::set<int>& wanted,
                                          const std::filesystem::path& kept, const Progress& progress,
                                          std::stop_token stop) {
  if (wanted.empty() || keyframes.empty()) return std::vector<Camera>();
  std::set<int> needed = wanted;
  for (const auto& keyframe : keyframes) needed.insert(keyframe.frame);
  if (auto source = kept_source(video, kept, small, needed)) {
    auto solved = resect(*source, video, keyframes, small, *needed.rbegin(), progress, stop);
    if (solved || solved.error().code != ErrorCode::io) return solved;
  }
  auto reader = VideoReader::open(video, VideoPixels::rgb, VideoFrames::sampled);
  if (!reader) return reader.error();
  reader->show_part(film);
  return resect(decoding_source(*reader, small, needed, stop), video, keyframes, small, *needed.rbegin(),
                progress, stop);
}

Pose mean_pose(const std::vector<Pose>& poses) {
  if (poses.empty()) return Pose::Identity();
  const auto mean_of = [](const std::vector<Pose>& group) {
    Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
    Vec3d centre = Vec3d::Zero();
    for (const auto& pose : group) {
      const Eigen::Vector4d q = Eigen::Quaterniond(pose.linear()).coeffs();
      sum += q * q.transpose();
      centre += inverse(pose).translation() / double(group.size());
    }
    Pose mean = Pose::Identity();
    mean.linear() = Eigen::Quaterniond(principal_axis(sum)).normalized().toRotationMatrix();
    mean.translation() = -(mean.linear() * centre);
    return mean;
  };
  // Distance of a pose from the rest: sum of its distances to all others; the inner two thirds are averaged.
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    double far = 0;
    for (const auto& other : poses)
      far += (inverse(poses[i]).translation() - inverse(other).translation()).norm();
    order.emplace_back(far, i);
  }
  std::sort(order.begin(), order.end());
  std::vector<Pose> inner;
  for (std::size_t i = 0; i < (2 * poses.size() + 2) / 3; ++i) inner.push_back(poses[order[i].second]);
  return mean_of(inner);
}

}  // namespace likeness
