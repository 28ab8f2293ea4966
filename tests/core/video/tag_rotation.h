// A film with the tag by which players turn its pictures, made by the ffmpeg program.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace likeness::test {

// Copies folder / from to folder / to, tagged to be shown turned by `degrees`, a multiple of 90. Versions
// from 6 on have an option for it, older ones a field of the metadata.
inline bool tag_rotation(const std::filesystem::path& folder, const std::string& from, const std::string& to,
                         int degrees) {
  const std::string start = "cd '" + folder.string() + "' && ffmpeg -y -loglevel error ",
                    turn = std::to_string(degrees);
  const auto runs = [&](const std::string& arguments) {
    return std::system((start + arguments + " > tag.log 2>&1").c_str()) == 0;
  };
  return runs("-display_rotation:v:0 " + turn + " -i " + from + " -c copy " + to) ||
         runs("-i " + from + " -c copy -metadata:s:v:0 rotate=" + turn + " " + to);
}

}  // namespace likeness::test
