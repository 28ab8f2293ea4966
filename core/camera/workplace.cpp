// Pictures and masks for colmap, and the hash that identifies their inputs.
#include "core/camera/workplace.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/files.h"
#include "core/image/files.h"

namespace likeness {

namespace fs = std::filesystem;

Result<void> prepare_work_folder(const fs::path& work, const std::string& inputs_hash) {
  if (auto made = make_writable_folder(work); !made) return made;
  std::error_code fault;
  const fs::path inputs = work / "inputs.txt";
  const auto stored = fs::exists(inputs, fault) ? read_text(inputs) : Result<std::string>(std::string());
  if (!stored || *stored != inputs_hash + "\n") {
    for (const char* name :
         {"images", "masks", "sparse", "refined", "all_sparse", "all_refined", "model", "database.db",
          "database.db-wal", "database.db-shm", "pictures.done", "features.done", "matches.done",
          "all_matches.done", "model.done", "all_model.done", "inputs.txt"}) {
      fs::remove_all(work / name, fault);
      if (fault) return file_error(work / name, "remove", fault.value());
    }
    if (auto written = write_text(inputs, inputs_hash + "\n"); !written) return written;
  }
  fs::remove_all(work / "snapshots", fault);  // of a solve that was killed
  for (const char* name : {"images", "masks"}) {
    fs::create_directories(work / name, fault);
    if (fault) return file_error(work / name, "create", fault.value());
  }
  return {};
}

bool pictures_ready(const fs::path& work) {
  std::error_code ignored;
  return fs::exists(work / "pictures.done", ignored);
}

Result<void> mark_pictures_ready(const fs::path& work) {
  return write_text(work / "pictures.done", "finished\n");
}

bool take_pictures(const fs::path& from, const std::string& inputs_hash, const fs::path& work) {
  if (!pictures_ready(from)) return false;
  const auto inputs = read_text(from / "inputs.txt");
  if (!inputs || *inputs != inputs_hash + "\n") return false;
  std::error_code fault;
  for (const char* name : {"images", "masks"})
    if (!fs::is_directory(from / name, fault)) return false;
  for (const char* name : {"images", "masks"}) {
    fs::remove_all(work / name, fault);
    if (!fault) fs::rename(from / name, work / name, fault);
    if (fault) break;
  }
  if (!fault) return bool(mark_pictures_ready(work));
  for (const char* name : {"images", "masks"}) fs::create_directories(work / name, fault);
  return false;
}

int reduced_height(int width, int height, int reduced_width) {
  return std::max(1, int(std::lround(double(height) * reduced_width / width)));
}

Result<void> write_picture(const fs::path& work, const std::string& name, const Image8& rgb,
                           const Image8& mask, int width) {
  const int height = reduced_height(rgb.width, rgb.height, width);
  if (auto written = write_image(work / "images" / name, resize(rgb, width, height)); !written)
    return written;
  Image8 kept(width, height, 1, 255);
  if (!mask.empty()) {
    const Image8 reduced = resize(mask, width, height);
    for (std::size_t i = 0; i < kept.data.size(); ++i) kept.data[i] = reduced.data[i] ? 0 : 255;
  }
  return write_image(work / "masks" / (name + ".png"), kept);
}

}  // namespace likeness
