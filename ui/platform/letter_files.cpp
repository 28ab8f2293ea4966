// See letter_files.h.
#include "ui/platform/letter_files.h"

#include <fontconfig/fontconfig.h>

#include <memory>

namespace likeness::ui {

namespace {

struct FreePattern {
  void operator()(FcPattern* p) const { FcPatternDestroy(p); }
};
struct FreeFonts {
  void operator()(FcFontSet* s) const { FcFontSetDestroy(s); }
};
using Fonts = std::unique_ptr<FcFontSet, FreeFonts>;

// All fonts that add letters to those before them, in the system's order.
Fonts sorted_fonts() {
  if (!FcInit()) return nullptr;
  const std::unique_ptr<FcPattern, FreePattern> wanted(
      FcNameParse(reinterpret_cast<const FcChar8*>("sans-serif")));
  if (!wanted) return nullptr;
  FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
  FcDefaultSubstitute(wanted.get());
  FcResult result = FcResultMatch;
  return Fonts(FcFontSort(nullptr, wanted.get(), FcTrue, nullptr, &result));
}

}  // namespace

std::optional<LetterFile> file_of_letter(char32_t letter) {
  static const Fonts fonts = sorted_fonts();
  for (int i = 0; fonts && i < fonts->nfont; ++i) {
    FcPattern* font = fonts->fonts[i];
    FcCharSet* letters = nullptr;
    FcChar8* path = nullptr;
    if (FcPatternGetCharSet(font, FC_CHARSET, 0, &letters) != FcResultMatch ||
        !FcCharSetHasChar(letters, letter) || FcPatternGetString(font, FC_FILE, 0, &path) != FcResultMatch)
      continue;
    LetterFile file{reinterpret_cast<const char*>(path)};
    FcPatternGetInteger(font, FC_INDEX, 0, &file.face);
    return file;
  }
  return std::nullopt;
}

}  // namespace likeness::ui
