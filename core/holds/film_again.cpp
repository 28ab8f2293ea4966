// The sentences.
#include "core/holds/film_again.h"

#include <algorithm>
#include <iterator>

namespace likeness {
namespace {

constexpr FilmRequest kFilmRequests[] = {
    {"jawOpen", "A wide open mouth", "Open the mouth wide, slowly, twice."},
    {"mouthSmile", "A smile", "Smile as broadly as you can and hold it for two seconds."},
    {"mouthPucker", "A pout", "Purse the lips as for a kiss, or say a long \"oo\"."},
    {"mouthFunnel", "A round \"oh\"", "Say a long, round \"oh\"."},
    {"mouthStretch", "A wide \"ee\"", "Say a long \"ee\" with the corners drawn wide."},
    {"mouthFrown", "A frown of the mouth", "Pull the corners of the mouth down."},
    {"browInnerUp", "A raising of the brows", "Raise the brows high and hold them for two seconds."},
    {"browDown", "A frown of the brows", "Draw the brows together and down."},
    {"eyeBlink", "A blink", "Close the eyes for a full second, twice."},
    {"cheekPuff", "A puffing of the cheeks", "Puff out both cheeks."},
    {"noseSneer", "A wrinkled nose", "Wrinkle the nose."},
};

}  // namespace

std::string_view side_words(HeadSide side) {
  constexpr std::string_view kWords[] = {"the person's left", "the person's right", "above", "below"};
  return kWords[std::size_t(side)];
}

std::string_view film_again_side(HeadSide side) {
  constexpr std::string_view kWords[] = {
      "Turn the head slowly to your right until the left ear faces the camera half way, and back.",
      "Turn the head slowly to your left until the right ear faces the camera half way, and back.",
      "Lower the chin slowly towards the chest, and back.", "Raise the chin slowly, and back."};
  return kWords[std::size_t(side)];
}

std::span<const FilmRequest> film_requests() { return kFilmRequests; }

const FilmRequest* find_film_request(std::string_view action) {
  const auto found = std::ranges::find(kFilmRequests, action, &FilmRequest::action);
  return found == std::end(kFilmRequests) ? nullptr : &*found;
}

}  // namespace likeness
