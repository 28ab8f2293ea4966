// The sequence of colmap's commands, its progress lines, and what its database says about a failure.
#include "core/camera/colmap.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <string_view>
#include <vector>

#include "core/base/files.h"
#include "core/base/parallel.h"
#include "core/camera/process.h"

namespace likeness {
namespace {

namespace fs = std::filesystem;

bool is_done(const fs::path& work, const char* step) {
  std::error_code ignored;
  return fs::exists(work / fmt::format("{}.done", step), ignored);
}

Result<void> mark_done(const fs::path& work, const char* step) {
  return write_text(work / fmt::format("{}.done", step), "finished\n");
}

struct Statement {
  sqlite3_stmt* handle = nullptr;
  ~Statement() { sqlite3_finalize(handle); }
};

// How many rows of a table's column `rows` are at least `least`; -1 when the table cannot be read.
int count_rows(sqlite3* database, const char* table, const char* column, int least,
               const char* further = "") {
  Statement statement;
  const std::string query =
      fmt::format("SELECT COUNT(*) FROM {} WHERE {} >= {}{}", table, column, least, further);
  if (sqlite3_prepare_v2(database, query.c_str(), -1, &statement.handle, nullptr) != SQLITE_OK) return -1;
  return sqlite3_step(statement.handle) == SQLITE_ROW ? sqlite3_column_int(statement.handle, 0) : -1;
}

struct Database {
  sqlite3* handle = nullptr;
  ~Database() { sqlite3_close(handle); }
};

// Id of a camera that an interrupted extraction left behind; -1 if there is none. Without it colmap adds a
// second one.
int stored_camera(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return -1;
  Database database;
  Statement statement;
  if (sqlite3_open_v2(path.c_str(), &database.handle, SQLITE_OPEN_READWRITE, nullptr) != SQLITE_OK) return -1;
  const char* query = "SELECT MIN(camera_id) FROM cameras";
  if (sqlite3_prepare_v2(database.handle, query, -1, &statement.handle, nullptr) != SQLITE_OK) return -1;
  if (sqlite3_step(statement.handle) != SQLITE_ROW) return -1;
  return sqlite3_column_type(statement.handle, 0) == SQLITE_NULL ? -1
                                                                 : sqlite3_column_int(statement.handle, 0);
}

// Gives the database's cameras this focal length, as a share of a picture's longer side, and no distortion
// (colmap's model RADIAL).
Result<void> start_from_focal(const fs::path& path, double focal) {
  const Error unwritable{ErrorCode::io, "The feature database of the camera solve cannot be written.",
                         "Check the disk, then run the same command again; finished steps are kept.",
                         path.string()};
  Database database;
  if (sqlite3_open_v2(path.c_str(), &database.handle, SQLITE_OPEN_READWRITE, nullptr) != SQLITE_OK)
    return unwritable;
  sqlite3_busy_timeout(database.handle, 2000);
  struct Lens {
    int camera, width, height;
  };
  std::vector<Lens> lenses;
  Statement read, write;
  if (sqlite3_prepare_v2(database.handle, "SELECT camera_id, width, height FROM cameras", -1, &read.handle,
                         nullptr) != SQLITE_OK ||
      sqlite3_prepare_v2(database.handle, "UPDATE cameras SET params = ? WHERE camera_id = ?", -1,
                         &write.handle, nullptr) != SQLITE_OK)
    return unwritable;
  int step = sqlite3_step(read.handle);
  for (; step == SQLITE_ROW; step = sqlite3_step(read.handle))
    lenses.push_back({sqlite3_column_int(read.handle, 0), sqlite3_column_int(read.handle, 1),
                      sqlite3_column_int(read.handle, 2)});
  if (step != SQLITE_DONE || lenses.empty()) return unwritable;
  for (const Lens& lens : lenses) {
    const double params[] = {focal * std::max(lens.width, lens.height), lens.width / 2.0, lens.height / 2.0,
                             0, 0};
    sqlite3_reset(write.handle);
    if (sqlite3_bind_blob(write.handle, 1, params, sizeof params, SQLITE_TRANSIENT) != SQLITE_OK ||
        sqlite3_bind_int(write.handle, 2, lens.camera) != SQLITE_OK ||
        sqlite3_step(write.handle) != SQLITE_DONE)
      return unwritable;
  }
  return {};
}

// One command of colmap. `pattern`: scanf format with two numbers, done and total, of its progress line.
struct Step {
  std::vector<std::string> arguments;
  const char* pattern = nullptr;
  std::string what;
};

// COLMAP 3.10, as 3.8 does not, puts severity, date, time, thread and source before a line:
// "I20260101 12:00:00.000000    26 timer.cc:91] ".
std::string_view without_log_prefix(std::string_view line) {
  constexpr std::size_t kDate = 9;  // a letter for the severity and eight digits
  if (line.size() < kDate || std::string_view("IWEF").find(line[0]) == std::string_view::npos ||
      line.substr(1, kDate - 1).find_first_not_of("0123456789") != std::string_view::npos)
    return line;
  const std::size_t end = line.find("] ");
  return end == std::string_view::npos ? line : line.substr(end + 2);
}

Result<ProcessEnd> run_step(const Step& step, int pictures, const Progress& progress, std::stop_token stop) {
  int registered = 0;
  progress.report(0, step.what);
  const auto on_line = [&](std::string_view text) {
    const std::string line(without_log_prefix(text));
    int done = 0, total = 0;
    if (step.pattern && std::sscanf(line.c_str(), step.pattern, &done, &total) == 2 && total > 0)
      progress.report(std::min(1.0, double(done) / total),
                      fmt::format("{}: {} of {}", step.what, done, total));
    if (std::sscanf(line.c_str(), "Registering image #%d (%d)", &done, &registered) == 2)
      progress.report(std::min(1.0, double(registered) / std::max(1, pictures)),
                      fmt::format("{}: {} of {} pictures placed", step.what, registered, pictures));
  };
  auto end = run_process(step.arguments, on_line, stop);
  if (!end && end.error().code == ErrorCode::missing_dependency)
    return Error{
        ErrorCode::missing_dependency,
        "The camera moves in this clip, and the program `colmap`, which finds its path, is not installed.",
        "Install it (Debian, Ubuntu: `apt install colmap`), or film with the camera on a tripod.",
        step.arguments[0]};
  if (end) progress.report(1, step.what);
  return end;
}

// Why a step of colmap failed, as far as its exit code and last output tell.
Error step_failed(const Step& step, const ProcessEnd& end) {
  const std::string command = fmt::format("`colmap {}`", step.arguments[1]);
  if (end.exit_code > 128)
    return {ErrorCode::io, fmt::format("{} was killed by signal {}.", command, end.exit_code - 128),
            "Memory may have run out: close other programs, then run the same command again; finished steps "
            "are kept.",
            "camera"};
  std::string last = end.tail.size() > 300 ? end.tail.substr(end.tail.size() - 300) : end.tail;
  std::replace(last.begin(), last.end(), '\n', ' ');
  if (end.tail.find("unrecognised option") != std::string::npos)
    return {ErrorCode::missing_dependency,
            fmt::format("The installed colmap lacks an option of version 3.8: {}", last),
            "Install version 3.8 to 3.11 of colmap (Debian 12: `apt install colmap`).", "camera"};
  if (end.tail.find("disk is full") != std::string::npos ||
      end.tail.find("No space left") != std::string::npos)
    return {ErrorCode::no_space, fmt::format("The disk is full: {} could not write its results.", command),
            "Free some space, then run the same command again; finished steps are kept.", "camera"};
  return {ErrorCode::io, fmt::format("{} ended with code {}: {}", command, end.exit_code, last),
          "Check free disk space and memory, then run the same command again; finished steps are kept.",
          "camera"};
}

Error no_texture(const ColmapCounts& counts) {
  return {
      ErrorCode::failed,
      fmt::format("The background has too little texture: only {} of {} pictures show enough features.",
                  counts.described, counts.pictures),
      "Film in front of a background with detail (shelves, posters, plants), in good light and without blur.",
      "camera"};
}

Error too_few_matches(const ColmapCounts& counts) {
  return {ErrorCode::failed,
          fmt::format("Too few pictures match: {} verified pairs among {} pictures.", counts.verified_pairs,
                      counts.pictures),
          "Move the camera more slowly and keep the background sharp and at rest.", "camera"};
}

Error hardly_moved(const ColmapCounts& counts) {
  return {ErrorCode::failed,
          fmt::format(
              "The camera hardly moved, or only turned on the spot: {} pairs of pictures match, but none of "
              "them shows enough parallax.",
              counts.verified_pairs),
          "Walk round the head in an arc of at least 30 degrees, or keep the camera entirely still; if it "
          "did rest, say so with `likeness build --resting-camera`.",
          "camera"};
}

// Where this share of the pairs says nothing of depth, and the points' own depth depends on such small
// angles, the camera turned on the spot.
constexpr double kFlatShare = 0.9, kMinParallax = 0.1;  // rad

struct SparseModel {
  fs::path folder;  // empty: none
  std::size_t pictures = 0, observations = 0;
  double reprojection_px = 0, focal = 0;
};

SparseModel describe(const fs::path& folder) {
  const auto model = read_colmap_model(folder);
  if (!model || model->cameras.empty()) return {};
  std::size_t observations = 0;
  for (const auto& image : model->images)
    observations +=
        std::size_t(std::ranges::count_if(image.observations, [](const auto& o) { return o.point >= 0; }));
  return {folder, model->images.size(), observations, mean_reprojection_px(*model),
          model->cameras.begin()->second.fx};
}

// The best reconstruction anywhere under a folder, where every try writes one, or several if the pictures
// fall into separate groups: among those that place nearly the most pictures with nearly the most features,
// the one with the least error. A wrong lens drops features that it cannot place.
SparseModel best_model(const fs::path& folder) {
  constexpr double kAboutAsMany = 0.9;
  std::vector<SparseModel> models;
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(folder, ignored))
    if (entry.path().filename() == "images.bin") models.push_back(describe(entry.path().parent_path()));
  for (const auto count : {&SparseModel::pictures, &SparseModel::observations}) {
    std::size_t most = 0;
    for (const SparseModel& model : models) most = std::max(most, model.*count);
    std::erase_if(models,
                  [&](const SparseModel& m) { return double(m.*count) < kAboutAsMany * double(most); });
  }
  const auto best = std::ranges::min_element(models, {}, &SparseModel::reprojection_px);
  return best == models.end() ? SparseModel{} : *best;
}

// Two solves from different starts found the same lens.
bool agree(const SparseModel& a, const SparseModel& b) {
  constexpr double kSameFocal = 0.02;
  return std::abs(a.focal - b.focal) <= kSameFocal * std::max(a.focal, b.focal);
}

// The mapper's tries, in order. A lens without distortion first, which is refined afterwards: with the
// distortion free from the first two pictures on, it often settles on a wrong focal length. Even so this
// happens, nearly always from a start shorter than the true one (docs/measurements/cameras.md): hence several
// starts, until two agree. Then ever less parallax and fewer matches, for sweeps of few degrees and pictures
// that are mostly person.
struct MapperTry {
  const char* folder;
  double focal;  // the start, as a share of the picture's longer side; most phones film with 0.7 to 1
  int seed;      // beyond the first
  std::vector<std::string> arguments;
};
const std::vector<std::string> kPlainLens = {"--Mapper.ba_refine_extra_params", "0"};
const MapperTry kMapperTries[] = {
    {"plain_lens", 1.2, 0, kPlainLens},
    {"longer_lens", 1.6, 0, kPlainLens},
    {"longest_lens", 2.2, 0, kPlainLens},
    {"plain_lens_again", 1.2, 1, kPlainLens},
    {"longer_lens_again", 1.6, 1, kPlainLens},
    {"lenient",
     1.2,
     0,
     {"--Mapper.init_min_tri_angle", "4", "--Mapper.init_min_num_inliers", "50",
      "--Mapper.abs_pose_min_num_inliers", "20", "--Mapper.abs_pose_min_inlier_ratio", "0.15"}},
    {"little_motion",
     1.2,
     0,
     {"--Mapper.init_min_tri_angle", "2", "--Mapper.init_min_num_inliers", "40",
      "--Mapper.init_max_forward_motion", "1", "--Mapper.abs_pose_min_num_inliers", "15",
      "--Mapper.abs_pose_min_inlier_ratio", "0.15", "--Mapper.filter_min_tri_angle", "0.7"}}};
constexpr int kPicturesASnapshot = 3;
constexpr std::size_t kStarts = 5;  // of these tries; after them one that places enough is accepted

enum class Pairs { neighbours, all };

struct Commands {
  fs::path work;
  ColmapOptions options;
  Pairs pairs = Pairs::neighbours;
  std::string threads;

  // The solve of all pairs has folders of its own: neither solve's results replace the other's.
  fs::path sparse() const { return work / (pairs == Pairs::all ? "all_sparse" : "sparse"); }
  fs::path snapshots() const { return work / "snapshots"; }  // of the running try
  fs::path refined() const { return work / (pairs == Pairs::all ? "all_refined" : "refined"); }

  // beyond: added to the seed.
  Step base(const char* command, std::string what, int beyond = 0) const {
    return {{options.program, command, "--random_seed", std::to_string(options.seed + beyond)},
            nullptr,
            std::move(what)};
  }
  Step extract() const {
    Step step = base("feature_extractor", "Looking for features");
    step.pattern = "Processed file [%d/%d]";
    const int camera = stored_camera(work / "database.db");
    step.arguments.insert(step.arguments.end(),
                          {"--database_path", work / "database.db", "--image_path", work / "images",
                           "--ImageReader.mask_path", work / "masks", "--ImageReader.camera_model", "RADIAL",
                           "--SiftExtraction.use_gpu", "0", "--SiftExtraction.num_threads", threads});
    step.arguments.insert(step.arguments.end(),
                          {"--SiftExtraction.max_num_features", std::to_string(options.features)});
    if (camera >= 0)
      step.arguments.insert(step.arguments.end(),
                            {"--ImageReader.existing_camera_id", std::to_string(camera)});
    else
      step.arguments.insert(step.arguments.end(), {"--ImageReader.single_camera", "1"});
    return step;
  }
  Step match() const {
    Step step = base(pairs == Pairs::all ? "exhaustive_matcher" : "sequential_matcher", "Matching pictures");
    step.pattern = pairs == Pairs::all ? "Matching block [%d/%d" : "Matching image [%d/%d]";
    step.arguments.insert(step.arguments.end(),
                          {"--database_path", work / "database.db", "--SiftMatching.use_gpu", "0",
                           "--SiftMatching.num_threads", threads});
    if (pairs == Pairs::all)
      step.arguments.insert(step.arguments.end(), {"--ExhaustiveMatching.block_size", "5"});
    else
      step.arguments.insert(step.arguments.end(),
                            {"--SequentialMatching.overlap", std::to_string(options.overlap)});
    return step;
  }
  Step map(const MapperTry& how) const {
    Step step = base("mapper", "Placing pictures", how.seed);
    step.arguments.insert(
        step.arguments.end(),
        {"--database_path", work / "database.db", "--image_path", work / "images", "--output_path",
         sparse() / how.folder, "--Mapper.num_threads", threads, "--Mapper.snapshot_path", snapshots(),
         "--Mapper.snapshot_images_freq", std::to_string(kPicturesASnapshot)});
    step.arguments.insert(step.arguments.end(), how.arguments.begin(), how.arguments.end());
    return step;
  }
  Step refine(const fs::path& model, bool principal_point) const {
    Step step = base("bundle_adjuster", "Refining the lens");
    step.arguments.insert(step.arguments.end(),
                          {"--input_path", model, "--output_path", refined(),
                           "--BundleAdjustment.refine_principal_point", principal_point ? "1" : "0"});
    return step;
  }
};

// A database that a crash or a full disk left unreadable is rebuilt: it holds only colmap's own work.
Result<void> drop_broken_database(const fs::path& work) {
  const fs::path database = work / "database.db";
  std::error_code fault;
  if (!fs::exists(database, fault) || count_database(database).ok()) return {};
  for (const char* name : {"database.db", "database.db-wal", "database.db-shm", "features.done",
                           "matches.done", "all_matches.done", "model.done", "all_model.done"}) {
    fs::remove(work / name, fault);
    if (fault) return file_error(work / name, "remove", fault.value());
  }
  return {};
}

// colmap drops pictures that it cannot read, or whose size differs, without an exit code.
Result<void> check_none_dropped(const fs::path& work, const ColmapCounts& counts) {
  int files = 0;
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator(work / "images", fault)) files += entry.is_regular_file();
  if (counts.pictures >= files) return {};
  return Error{
      ErrorCode::failed,
      fmt::format("colmap could read only {} of the {} pictures prepared for it.", counts.pictures, files),
      "Check the disk, delete this folder and run the same command again.", work.string()};
}

Result<void> describe_and_match(const Commands& commands, const Progress& progress, std::stop_token stop) {
  const fs::path& work = commands.work;
  if (auto sound = drop_broken_database(work); !sound) return sound;
  if (!is_done(work, "features")) {
    const Step step = commands.extract();
    const auto end = run_step(step, 0, progress.stage(0, 0.5, "features"), stop);
    if (!end) return end.error();
    if (end->exit_code != 0) return step_failed(step, *end);
    if (auto marked = mark_done(work, "features"); !marked) return marked;
  }
  const auto counts = count_database(work / "database.db");
  if (!counts) return counts.error();
  if (auto complete = check_none_dropped(work, *counts); !complete) return complete;
  if (counts->described < std::max(3, counts->pictures / 3)) return no_texture(*counts);
  const char* step_name = commands.pairs == Pairs::all ? "all_matches" : "matches";
  if (!is_done(work, step_name)) {
    const Step step = commands.match();
    const auto end = run_step(step, 0, progress.stage(0.5, 1, "matches"), stop);
    if (!end) return end.error();
    if (end->exit_code != 0) return step_failed(step, *end);
    if (auto marked = mark_done(work, step_name); !marked) return marked;
  }
  return {};
}

Result<void> make_empty(const fs::path& folder) {
  std::error_code fault;
  fs::remove_all(folder, fault);
  fs::create_directories(folder, fault);
  if (fault) return file_error(folder, "create", fault.value());
  return {};
}

// Sparse reconstruction, until two tries agree on the lens or all starts are used up. The best of all solves
// is kept, whichever two agreed.
Result<void> map_pictures(const Commands& commands, const ColmapCounts& counts, const Progress& progress,
                          std::stop_token stop) {
  if (counts.verified_pairs < 2) return too_few_matches(counts);
  if (auto made = make_empty(commands.sparse()); !made) return made;
  const double share = 1.0 / double(std::size(kMapperTries));
  std::vector<SparseModel> enough;  // that place enough pictures
  for (std::size_t i = 0; i < std::size(kMapperTries); ++i) {
    for (const fs::path& folder : {commands.sparse() / kMapperTries[i].folder, commands.snapshots()})
      if (auto made = make_empty(folder); !made) return made;
    if (auto started = start_from_focal(commands.work / "database.db", kMapperTries[i].focal); !started)
      return started;
    const Step step = commands.map(kMapperTries[i]);
    const auto end = run_step(step, counts.pictures,
                              progress.stage(share * double(i), share * double(i + 1), "try"), stop);
    if (!end) return end.error();
    const SparseModel now = best_model(commands.sparse() / kMapperTries[i].folder);
    if (double(now.pictures) >= kEnoughPlaced * counts.described) {
      if (std::ranges::any_of(enough, [&](const SparseModel& other) { return agree(now, other); })) return {};
      enough.push_back(now);
    }
    if (i + 1 >= kStarts && !enough.empty()) return {};
    if (end->tail.find("No images with matches found") != std::string::npos) return too_few_matches(counts);
    const bool no_start = end->tail.find("failed to create sparse model") != std::string::npos ||
                          end->tail.find("initial image pair") != std::string::npos;
    if (end->exit_code != 0 && !no_start)
      return enough.empty() ? step_failed(step, *end)
                            : Result<void>{};  // another start would only have confirmed it
  }
  if (best_model(commands.sparse()).pictures == 0) return hardly_moved(counts);
  return {};
}

// Two focal lengths, four terms of distortion and the principal point of the best reconstruction, as far as
// its pictures show them. So many more parameters fit the noise of any pictures a little better: by less than
// a thousandth where the lens had no distortion to find, by 5 % with a phone (docs/measurements/cameras.md).
// A principal point that few pictures constrain may drift; that phone's was 1.4 % of the width off the
// centre.
Result<ColmapModel> refine_lens(const Commands& commands, const Progress& progress, std::stop_token stop) {
  constexpr double kPlausible = 0.03, kWorthwhile = 0.02;
  const fs::path found_in = best_model(commands.sparse()).folder;
  auto found = read_colmap_model(found_in);
  if (!found) return found;
  const fs::path start = commands.refined() / "start";
  if (auto made = make_empty(start); !made) return made.error();
  std::error_code fault;
  fs::copy(found_in, start, fs::copy_options::recursive | fs::copy_options::overwrite_existing, fault);
  if (fault) return file_error(start, "write", fault.value());
  if (auto written = write_colmap_cameras(start, found->cameras); !written) return written.error();
  for (const bool principal_point : {true, false}) {
    const auto end =
        run_step(commands.refine(start, principal_point), 0,
                 principal_point ? progress.stage(0, 0.5, "lens") : progress.stage(0.5, 1, "lens"), stop);
    if (!end) return end.error();
    auto refined = read_colmap_model(commands.refined());
    if (end->exit_code != 0 || !refined) break;  // what was found is kept
    const Intrinsics& k = refined->cameras.begin()->second;
    const bool plausible = std::abs(k.cx - k.width / 2.0) <= kPlausible * k.width &&
                           std::abs(k.cy - k.height / 2.0) <= kPlausible * k.height;
    const bool worthwhile =
        mean_reprojection_px(*refined) <= (1 - kWorthwhile) * mean_reprojection_px(*found);
    if (plausible && worthwhile) return refined;
    if (!worthwhile) break;  // even with every number free
  }
  fs::copy(found_in, commands.refined(), fs::copy_options::recursive | fs::copy_options::overwrite_existing,
           fault);
  if (fault) return file_error(commands.refined(), "write", fault.value());
  return found;
}

Result<ColmapModel> solve_pairs(const Commands& commands, const Progress& progress, std::stop_token stop) {
  if (auto ready = describe_and_match(commands, progress.stage(0, 0.75, "matching"), stop); !ready)
    return ready.error();
  const auto counts = count_database(commands.work / "database.db");
  if (!counts) return counts.error();
  const char* step_name = commands.pairs == Pairs::all ? "all_model" : "model";
  if (!is_done(commands.work, step_name)) {
    if (auto mapped = map_pictures(commands, *counts, progress.stage(0.75, 0.95, "mapping"), stop); !mapped)
      return mapped.error();
    if (auto lens = refine_lens(commands, progress.stage(0.95, 1, "lens"), stop); !lens) return lens;
    if (auto marked = mark_done(commands.work, step_name); !marked) return marked.error();
  }
  progress.report(1);
  auto model = read_colmap_model(commands.refined());
  // Allowed ever less parallax, the mapper makes a path out of noise for a camera that only turned.
  if (model && double(counts->flat_pairs) >= kFlatShare * counts->verified_pairs &&
      median_parallax(*model) < kMinParallax)
    return hardly_moved(*counts);
  return model;
}

// Puts the chosen solve where its readers expect it.
Result<void> keep_solve(const Commands& commands) {
  const fs::path folder = solved_model_path(commands.work);
  if (auto made = make_empty(folder); !made) return made;
  std::error_code fault;
  fs::copy(commands.refined(), folder, fault);
  if (fault) return file_error(folder, "write", fault.value());
  return {};
}

}  // namespace

Result<ColmapCounts> count_database(const fs::path& path) {
  const Error unreadable{ErrorCode::failed, "The feature database of the camera solve cannot be read.",
                         "Delete the work folder of the cameras and run the same command again.",
                         path.string()};
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return unreadable;
  Database database;
  if (sqlite3_open_v2(path.c_str(), &database.handle, SQLITE_OPEN_READWRITE, nullptr) != SQLITE_OK)
    return unreadable;
  sqlite3_busy_timeout(database.handle, 2000);
  ColmapCounts counts;
  counts.pictures = count_rows(database.handle, "images", "image_id", 0);
  counts.described = count_rows(database.handle, "keypoints", "rows", 51);
  counts.verified_pairs = count_rows(database.handle, "two_view_geometries", "rows", 15);
  // colmap's kinds of a pair: 5 panoramic, 6 planar or panoramic.
  counts.flat_pairs = count_rows(database.handle, "two_view_geometries", "rows", 15, " AND config IN (5, 6)");
  if (counts.pictures < 0 || counts.described < 0 || counts.verified_pairs < 0) return unreadable;
  return counts;
}

fs::path solved_model_path(const fs::path& work) { return work / "model"; }

Result<ColmapModel> solve_colmap(const fs::path& work, const ColmapOptions& options, const Progress& progress,
                                 std::stop_token stop) {
  const int threads = options.threads > 0 ? options.threads : current_thread_limit();
  Commands commands{work, options, Pairs::neighbours, std::to_string(std::max(1, threads))};
  const struct Watched {  // only while solving
    fs::path folder;
    explicit Watched(fs::path f) : folder(std::move(f)) { clear(); }
    ~Watched() { clear(); }
    void clear() const {
      std::error_code ignored;
      fs::remove_all(folder, ignored);
    }
  } watched(commands.snapshots());
  auto model = solve_pairs(commands, progress.stage(0, 0.8, "neighbours"), stop);
  if (!model && model.error().code != ErrorCode::failed) return model;
  const auto counts = count_database(work / "database.db");
  const auto placed = [](const Result<ColmapModel>& m) { return m ? m->images.size() : std::size_t(0); };
  // A path that crosses itself is held together by pairs that are not neighbours.
  if (counts && counts->pictures <= options.max_for_all_pairs &&
      double(placed(model)) < options.enough * counts->pictures) {
    Commands all = commands;
    all.pairs = Pairs::all;
    auto again = solve_pairs(all, progress.stage(0.8, 1, "all pairs"), stop);
    if (!again && (!model || again.error().code == ErrorCode::cancelled)) return again;
    if (placed(again) > placed(model)) model = std::move(again), commands = all;
  }
  if (!model) return model;
  if (auto kept = keep_solve(commands); !kept) return kept.error();
  progress.report(1);
  return model;
}

std::optional<ColmapModel> solve_so_far(const fs::path& work) {
  std::vector<std::pair<fs::file_time_type, fs::path>> written;
  std::error_code fault;
  for (fs::directory_iterator at(Commands{work, {}, {}, {}}.snapshots(), fault), end; !fault && at != end;
       at.increment(fault)) {
    std::error_code gone;
    const auto when = at->last_write_time(gone);
    if (!gone) written.emplace_back(when, at->path());
  }
  std::ranges::sort(written, std::greater());
  for (const auto& [when, folder] : written)
    if (auto model = read_colmap_model(folder); model && !model->images.empty()) return std::move(*model);
  return std::nullopt;
}

}  // namespace likeness
