// Upright pixels of a decoded frame: see decoded_picture.h.
#include "core/video/decoded_picture.h"

#include <utility>

#include "core/video/alpha.h"
#include "core/video/photos.h"

namespace likeness {

Image8 DecodedPictures::upright(Image8 picture, const PixelRect& place) const {
  if (picture.empty()) return picture;
  Image8 coded = put_in_place(std::move(picture), place, width_, height_);
  const bool as_coded = !orientation_.transposed && !orientation_.flip_x && !orientation_.flip_y;
  return as_coded ? std::move(coded) : oriented(coded, orientation_);
}

PixelRect DecodedPictures::part_of(int shape) const {
  PixelRect place = shapes_.place_of(shape);
  if (orientation_.flip_x) place.x = width_ - place.right();
  if (orientation_.flip_y) place.y = height_ - place.bottom();
  return orientation_.transposed ? PixelRect{place.y, place.x, place.height, place.width} : place;
}

bool DecodedPictures::show_masked(const AVFrame& decoded, const PixelRect& place, DecodedPicture& result) {
  const Image8 rgba = to_rgb_.to_rgba(decoded, place.width, place.height);
  if (rgba.empty()) return false;
  ShownPicture shown = over_backdrop(rgba);
  result.rgb = upright(std::move(shown.rgb), place);
  result.luma = luma_of_photo(result.rgb);
  result.alpha = upright(std::move(shown.alpha), place);
  return true;
}

bool DecodedPictures::show(const AVFrame& decoded, bool rgb, bool luma, const PixelRect& part,
                           DecodedPicture& result) {
  const PixelRect place = shapes_.place(decoded);
  if (has_alpha(decoded)) {
    if (!show_masked(decoded, place, result)) return false;
  } else {
    if (luma) result.luma = upright(to_luma_.to_luma(decoded, place.width, place.height), place);
    if (rgb) result.rgb = upright(to_rgb_.to_rgb(decoded, place.width, place.height), place);
    if ((luma && result.luma.empty()) || (rgb && result.rgb.empty())) return false;
  }
  if (part.empty()) return true;
  for (Image8* picture : {&result.rgb, &result.luma, &result.alpha})
    if (!picture->empty()) *picture = crop(*picture, part);
  return true;
}

}  // namespace likeness
