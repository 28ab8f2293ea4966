// A small network that tells people from everything else (core/network/installed_networks.h: person), as the
// prior of masks and mattes: its outline is good to a few millimetres of a head-and-shoulders picture, but
// smooth; strands of hair are lost, and a thin rim of the background stays.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/face/landmarks.h"
#include "core/image/image.h"

namespace likeness {

// Pixels [x, x + width) x [y, y + height) of a picture.
struct PictureRect {
  int x = 0, y = 0, width = 0, height = 0;

  bool operator==(const PictureRect&) const = default;
};

// The part of a picture round the person whose face is at `face`, inside the picture, as large as heads,
// shoulders and gesturing hands need. widen: times the usual size.
PictureRect person_rect(const FaceBox& face, int width, int height, double widen = 1);

// once: 15 ms. both_ways: the mean of the picture's share and its mirror image's, twice as long. Furniture
// that is taken for a person one way round seldom is the other way, so that its share says how doubtful it
// is.
enum class Looks { once, both_ways };

class PersonNetwork {
 public:
  // As a user's file; installed() as the one that came with the program.
  static Result<PersonNetwork> load(const std::filesystem::path& onnx);
  static Result<PersonNetwork> installed();
  ~PersonNetwork();
  PersonNetwork(PersonNetwork&&) noexcept;
  PersonNetwork& operator=(PersonNetwork&&) noexcept;

  // The share of person, 0..255, at the size of an RGB picture in which people are large. Seen on a grid of
  // 256 x 256, whatever the picture's format. May be called by several threads.
  Result<Image8> share(const Image8& rgb, Looks looks = Looks::both_ways) const;
  // The same of a part of the picture, which must lie inside it; outside the part, the nearest pixel's.
  Result<Image8> share_in(const Image8& rgb, const PictureRect& part, Looks looks = Looks::both_ways) const;
  // The same of the person whose face is at `face`, however small in the picture: of a part round them, which
  // is widened while they reach beyond its sides; 0 outside the part.
  Result<Image8> share_about(const Image8& rgb, const FaceBox& face, Looks looks = Looks::both_ways) const;

 private:
  struct Impl;
  explicit PersonNetwork(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// What a project's choice of a network means: empty is the installed one if there is one, "none" is none, and
// anything else is a file. Null: none. A file that is there and cannot be used is an error.
Result<std::shared_ptr<const PersonNetwork>> chosen_person_network(const std::filesystem::path& choice);
// For results that depend on it; empty if none is used.
std::string person_network_hash(const std::filesystem::path& choice);

}  // namespace likeness
