// What to film so that an avatar holds where it does not: one sentence to the person before the camera.
#pragma once

#include <span>
#include <string_view>

namespace likeness {

// From where a head is looked at.
enum class HeadSide { left, right, above, below };  // left, right: the person's
std::string_view side_words(HeadSide side);         // "the person's left", "above"
std::string_view film_again_side(HeadSide side);

// What people can be asked to do, for the actions that matter most in a face that speaks.
struct FilmRequest {
  std::string_view action, what, words;  // "mouthSmile", "A smile", "Smile as broadly as ..."
};
std::span<const FilmRequest> film_requests();
// By the action's name without its side; nullptr where there is none.
const FilmRequest* find_film_request(std::string_view action);

}  // namespace likeness
