// FLAME's pickles: see flame.h.
#include "core/head/flame.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "core/head/pickle.h"
#include "core/head/pickle_arrays.h"

namespace likeness {
namespace {

constexpr std::array kArrays{"v_template", "shapedirs",     "posedirs", "J_regressor",
                             "weights",    "kintree_table", "f"};

constexpr const char* kNoFlame =
    "Choose FLAME's generic_model.pkl, female_model.pkl, male_model.pkl, flame2023.pkl or "
    "flame2023_no_jaw.pkl (https://flame.is.tue.mpg.de), an ICT-FaceKit folder or a .npz, or leave the head "
    "model out.";

}  // namespace

const char* flame_relative(std::size_t vertices, std::size_t joints) {
  if (vertices == 10475 || joints == 55) return "SMPL-X, a body model";
  if (joints == 52) return "SMPL-H, a body model";
  if (vertices == 6890 || joints == 24) return "SMPL, a body model";
  if (vertices == 778 || joints == 16) return "MANO, a hand model";
  return nullptr;
}

Result<NpzArchive> read_flame_pickle(std::span<const std::byte> file, const std::string& where) {
  const auto document = read_pickle(file, where);
  if (!document) return document.error();
  const auto wrong = [&](std::string what) {
    return Error{ErrorCode::bad_input, std::move(what), kNoFlame, where};
  };
  if (document->node(document->root).kind != PickleKind::dict)
    return wrong("The pickle does not hold a dictionary, which a FLAME model is.");
  NpzArchive archive;
  for (const char* key : kArrays) {
    const PickleRef* found = find_key(*document, document->root, key);
    if (!found) continue;  // the loader names what is missing
    auto array = pickle_array(*document, *found);
    if (!array) return wrong(fmt::format("{}: {}", key, array.error().what));
    archive.emplace(key, std::move(*array));
  }
  const auto extent = [&](const char* key, std::size_t axis) {
    const auto entry = archive.find(key);
    return entry != archive.end() && entry->second.shape.size() > axis ? entry->second.shape[axis] : 0;
  };
  if (const char* name = flame_relative(extent("v_template", 0), extent("weights", 1)))
    return wrong(fmt::format("The file is {}, not FLAME.", name));
  if (archive.empty()) return wrong("The pickle has none of FLAME's keys.");
  return archive;
}

Result<void> unpack_objects(NpzArchive& archive, const std::string& where) {
  for (auto& [key, array] : archive) {
    if (array.kind != 'O' || array.count() != 1) continue;
    const auto document = read_pickle(array.data, where);
    if (!document)
      return Error{document.error().code, key + ": " + document.error().what, document.error().fix, where};
    const auto elements = pickle_elements(*document, document->root);
    if (!elements || elements->size() != 1) continue;
    auto inner = pickle_array(*document, elements->front());
    if (inner)
      array = std::move(*inner);  // what is not an array stays unread; the loader will ask for numbers
  }
  return {};
}

std::string flame_name(const std::filesystem::path& path) {
  std::string text = path.parent_path().filename().string() + '/' + path.stem().string();
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  std::string name = "FLAME";
  for (const char* year : {"2016", "2017", "2019", "2020", "2023"})
    if (text.find(year) != std::string::npos) name = std::string("FLAME ") + year;
  const std::string stem = text.substr(text.find('/') + 1);
  if (stem.starts_with("female")) return name + " (female)";
  if (stem.starts_with("male")) return name + " (male)";
  if (stem.find("no_jaw") != std::string::npos) return name + " (expressions without jaw)";
  return name;
}

}  // namespace likeness
