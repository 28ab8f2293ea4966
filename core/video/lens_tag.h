// What a phone's film says about its lens: Apple's cameras write it into the film's track, as "mdta" metadata
// (QuickTime File Format, Metadata atoms), which FFmpeg shows of the whole film only.
#pragma once

#include <filesystem>

namespace likeness {

// Focal length, in mm, of the lens that shows the same angle on 35 mm film; 0 where an MP4 or MOV file does not
// tell it, tells what no phone has, or cannot be read. It outlives a cut and a crop by an editor.
double read_focal_35mm(const std::filesystem::path& path);

// The film's longer side. Of 27 mm an iPhone 13 speaks whose picture is 6.86 mm wide behind a lens of 5.1 mm:
// 26.8 by the width; its stills, measured by their diagonal, say 26.
inline constexpr double kFilmWidth_mm = 36;

}  // namespace likeness
