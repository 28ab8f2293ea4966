// What kind of picture a file holds, by its first bytes: a name says nothing about it.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace likeness {

// Those that are opened, each by its own reader; every further reader is code that a stranger's file could
// reach.
enum class PictureKind { png, jpeg, tiff, webp, exr, heif, other };

struct FoundKind {
  PictureKind kind = PictureKind::other;
  std::string name;  // of an `other` that is known, e.g. "a GIF"; empty: it may be anything
};

// Raw pictures of cameras (DNG, NEF, CR2, ...) lie in TIFFs and are none: what a TIFF reader shows is a
// thumbnail.
FoundKind picture_kind(std::span<const std::byte> bytes);

// OpenImageIO's name of the reader.
const char* reader_of(PictureKind kind);

}  // namespace likeness
