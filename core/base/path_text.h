// Paths as text in JSON files. A path is bytes, and JSON is UTF-8: names of old disks, cards and archives are
// often in another encoding, and lead nowhere if a byte is lost.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace likeness {

// UTF-8, whatever the path. Paths that are UTF-8 stay as they are; of others each byte that is not becomes a
// character of its own, U+10FE00 + byte, which is for private use.
std::string text_of_path(const std::filesystem::path& path);
std::filesystem::path path_of_text(std::string_view text);  // the same bytes again

}  // namespace likeness
