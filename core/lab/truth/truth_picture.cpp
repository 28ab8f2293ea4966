// See truth_picture.h.
#include "core/lab/truth/truth_picture.h"

#include <fmt/format.h>

#include "core/image/files.h"

namespace likeness {

Result<Image8> read_truth_picture(const std::filesystem::path& path, int channels) {
  auto picture = read_image(path);
  if (!picture || picture->channels == channels) return picture;
  return Error{ErrorCode::bad_input,
               fmt::format("{} has {} channels; {} of a demo have {}.", path.string(), picture->channels,
                           channels == 1 ? "masks" : "pictures", channels),
               "Write the demo again: likeness demo FOLDER", path.string()};
}

}  // namespace likeness
