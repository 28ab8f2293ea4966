// What a phone's film says about its lens: Apple's cameras write it into the film's track, as "mdta" metadata
// (QuickTime File Format, Metadata atoms), which FFmpeg shows of the whole film only.
#pragma once

#include <filesystem>

namespace likeness {

// Focal length, in mm, of the lens that shows the same angle on 35 mm film; 0 where an MP4 or MOV file does
// not tell it, tells what no phone has, or cannot be read. It outlives a cut and a crop by an editor.
double read_focal_35mm(const std::filesystem::path& path);

// The film's longer side. That Apple measures by it and not by the diagonal is inferred: an iPhone 13 is
// reported to write 27 where its stills, measured by their diagonal, say 26. Not checked on a film of a known
// angle.
inline constexpr double kFilmWidth_mm = 36;

}  // namespace likeness
