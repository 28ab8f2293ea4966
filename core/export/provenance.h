// What every exported file says about itself: that it is synthetic, what made it, from which avatar, when.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace likeness {

// IPTC's term for media made by a model that was trained on captured content.
inline constexpr const char* kDigitalSourceType =
    "http://cv.iptc.org/newscodes/digitalsourcetype/trainedAlgorithmicMedia";

struct Provenance {
  std::string program;      // "Likeness 0.1.0"
  std::string project;      // the project folder's name, without its path
  std::string avatar_hash;  // of avatar.bin
  std::string made_at;      // UTC, ISO 8601
  std::string consent{};    // of the person shown: own, given, no_real_person; not_asked; empty: not said
};
Provenance provenance(const std::string& project, const std::string& avatar_hash,
                      std::chrono::system_clock::time_point made_at);

std::string provenance_sentence(const Provenance& provenance);  // for people
std::string provenance_json(const Provenance& provenance);      // for programs, one line
std::string provenance_xmp(const Provenance& provenance);  // an XMP packet with Iptc4xmpExt and xmp terms

// Texts of a PNG and tags of an mp4.
std::vector<std::pair<std::string, std::string>> png_provenance(const Provenance& provenance);
std::vector<std::pair<std::string, std::string>> mp4_provenance(const Provenance& provenance);

}  // namespace likeness
