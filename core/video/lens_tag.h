// What a phone's film says about its lens: Apple's cameras write it into the film's track, as "mdta" metadata
// (QuickTime File Format, Metadata atoms), which FFmpeg exposes only for the whole film.
#pragma once

#include <filesystem>

namespace likeness {

// Focal length, in mm, equivalent on 35 mm film; 0 if an MP4 or MOV file does not record it, records one that
// no phone has, or cannot be read. It survives cutting and cropping by an editor.
double read_focal_35mm(const std::filesystem::path& path);

// The tag's key, as Apple's cameras write it.
inline constexpr const char* kFocalLengthTag = "com.apple.quicktime.camera.focal_length.35mm_equivalent";

// The film's longer side. That Apple measures by it and not by the diagonal is inferred: an iPhone 13 is
// reported to write 27 where its stills, measured by their diagonal, say 26. Not checked on a film of a known
// angle.
inline constexpr double kFilmWidth_mm = 36;

}  // namespace likeness
