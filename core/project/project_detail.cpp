// detail.npz: see project_detail.h.
#include "core/project/project_detail.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <new>

#include "core/base/files.h"
#include "core/base/npz.h"
#include "core/head/detail_maps.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMinFrames = 10;
constexpr double kHardlyExplained = 0.2;  // of the maps' variance: less is worth a warning

using RowMajor = Eigen::Matrix<float, -1, -1, Eigen::RowMajor>;

NpyArray array_of(const Eigen::MatrixXf& m) {
  const RowMajor rows = m;
  return npy_from_floats({std::size_t(m.rows()), std::size_t(m.cols())},
                         {rows.data(), std::size_t(rows.size())});
}
NpyArray array_of(const Eigen::VectorXf& v) {
  return npy_from_floats({std::size_t(v.size())}, {v.data(), std::size_t(v.size())});
}

Error damaged(const fs::path& path) {
  return {ErrorCode::bad_input, fmt::format("{} is damaged.", path.string()),
          "Delete it and run likeness train, so that it is made again from the detail maps.", path.string()};
}

// Throws std::out_of_range if the array is missing.
Eigen::MatrixXf matrix_of(const NpzArchive& archive, const char* key) {
  const NpyArray& array = archive.at(key);
  const std::vector<float> values = array.as_float();
  const auto rows = array.shape.empty() ? 0 : Eigen::Index(array.shape[0]),
             columns = array.shape.size() > 1 ? Eigen::Index(array.shape[1]) : 1;
  if (rows * columns != Eigen::Index(values.size())) return {};
  return Eigen::Map<const RowMajor>(values.data(), rows, columns);
}

}  // namespace

Result<ProjectDetail> learn_project_detail(const fs::path& maps, const Capture& capture, const Track& track,
                                           const HeadModel& model, DetailReport& report) {
  auto read = read_detail_maps(maps, model);
  if (!read) return read.error();
  std::vector<DetailFrame> frames;
  std::size_t trained = 0, known = 0;
  for (const CaptureFrame& frame : capture.frames) {
    const auto map =
        std::ranges::lower_bound(*read, frame.frame, {}, [](const DetailMap& m) { return m.frame; });
    const bool given = map != read->end() && map->frame == frame.frame;
    known += given;
    const TrackedFrame* tracked = find_tracked(track, frame.frame);
    if (!frame.used || tracked == nullptr || tracked->status == FrameStatus::lost) continue;
    ++trained;
    if (given) frames.push_back({frame.frame, std::move(map->height), tracked->pose.articulation});
  }
  if (frames.size() < kMinFrames)
    return Error{
        ErrorCode::bad_input,
        fmt::format("Of the {} maps in {} {} are of frames of this clip and {} of tracked training "
                    "frames; {} of these are needed.",
                    read->size(), maps.string(), known, frames.size(), kMinFrames),
        "Name the files by the frames' numbers in the clip, which start at 0, and give more of them.",
        maps.string()};
  LearntDetail learnt = learn_detail(frames);
  ProjectDetail detail{std::move(learnt.detail), {}, ""};
  for (std::size_t i = 0; i < frames.size(); ++i)
    detail.scores.emplace(frames[i].frame, learnt.scores.row(Eigen::Index(i)).transpose());
  report.message = fmt::format(
      "Detail of {} of {} training frames: {} components hold {:.0f} %, the expression explains {:.0f} % of "
      "it.",
      frames.size(), trained, detail.detail.components(), 100 * learnt.kept, 100 * learnt.explained);
  if (detail.detail.empty())
    report.warnings.push_back("The detail maps are flat: they change nothing.");
  else if (learnt.explained < kHardlyExplained)
    report.warnings.push_back(
        fmt::format("The detail maps hardly follow the expression ({:.0f} %): a new expression gets little "
                    "more than their mean.",
                    100 * learnt.explained));
  return detail;
}

Result<void> write_project_detail(const Project& project, const ProjectDetail& kept) {
  const ExpressionDetail& d = kept.detail;
  std::vector<std::int32_t> frames;
  Eigen::MatrixXf scores(Eigen::Index(kept.scores.size()), d.basis.cols());
  for (const auto& [frame, own] : kept.scores) {
    scores.row(Eigen::Index(frames.size())) = own.transpose();
    frames.push_back(frame);
  }
  const std::vector<std::int32_t> track(kept.track_inputs.begin(), kept.track_inputs.end());
  return write_npz(detail_path(project), {{"vertices", npy_from_ints({d.vertices.size()}, d.vertices)},
                                          {"mean", array_of(d.mean)},
                                          {"basis", array_of(d.basis)},
                                          {"middle", array_of(d.middle)},
                                          {"rows", array_of(d.rows)},
                                          {"low", array_of(d.low)},
                                          {"high", array_of(d.high)},
                                          {"frames", npy_from_ints({frames.size()}, frames)},
                                          {"scores", array_of(scores)},
                                          {"track", npy_from_ints({track.size()}, track)}});
}

Result<void> forget_project_detail(const Project& project) {
  std::error_code failure;
  fs::remove(detail_path(project), failure);
  if (failure) return file_error(detail_path(project), "remove", failure.value());
  return {};
}

Result<std::optional<ProjectDetail>> read_project_detail(const Project& project, const HeadModel& model) {
  const fs::path path = detail_path(project);
  if (std::error_code ignored; !fs::exists(path, ignored)) return std::optional<ProjectDetail>();
  const auto archive = read_npz(path);
  if (!archive) return damaged(path);
  ProjectDetail kept;
  ExpressionDetail& d = kept.detail;
  try {
    d.vertices = archive->at("vertices").as_int();
    d.mean = matrix_of(*archive, "mean"), d.basis = matrix_of(*archive, "basis");
    d.middle = matrix_of(*archive, "middle"), d.rows = matrix_of(*archive, "rows");
    d.low = matrix_of(*archive, "low"), d.high = matrix_of(*archive, "high");
    const std::vector<std::int32_t> frames = archive->at("frames").as_int();
    const Eigen::MatrixXf scores = matrix_of(*archive, "scores");
    for (const std::int32_t letter : archive->at("track").as_int()) kept.track_inputs += char(letter);
    if (!is_consistent(d, model.vertex_count(), model.expression_count()) || !scores.allFinite() ||
        scores.rows() != Eigen::Index(frames.size()) || scores.cols() != d.basis.cols())
      return damaged(path);
    for (std::size_t i = 0; i < frames.size(); ++i)
      kept.scores[frames[i]] = scores.row(Eigen::Index(i)).transpose();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    return damaged(path);
  }
  return std::optional(std::move(kept));
}

void take_detail(const ProjectDetail& detail, TrainingSet& set) {
  set.detail = detail.detail;
  for (TrainingView& view : set.views) {
    if (view.further_clip != 0) continue;
    const auto own = detail.scores.find(view.camera.frame);
    if (own != detail.scores.end()) view.pose.detail = own->second;
  }
}

}  // namespace likeness
