// See make_mattes.h.
#include "core/project/make_mattes.h"

#include <system_error>
#include <utility>

#include "core/matte/matte.h"
#include "core/matte/person_network.h"
#include "core/project/corrections.h"
#include "core/project/further_clips.h"
#include "core/project/learn_room.h"

namespace likeness {

Result<MatteResult> make_mattes(const Project& project, const MatteInputs& inputs,
                                const std::filesystem::path& folder, const TrackedCapture& read,
                                const HeadModel& model, const Progress& progress, std::stop_token stop,
                                std::shared_ptr<KeptWork> kept) {
  auto strokes = read_corrections(project);
  if (!strokes) return strokes.error();
  MatteOptions options;
  options.size = read.capture.size;
  options.network = inputs.choices.matting_network;
  if (options.network.empty()) {
    auto person = chosen_person_network(inputs.person_network);
    if (!person) return person.error();
    options.person_network = std::move(*person);
  }
  options.strokes = std::move(*strokes);
  options.kept = std::move(kept);
  Project work = project;
  work.folder = folder;
  std::error_code ignored;
  std::filesystem::remove(room_path(work), ignored);  // it was learnt from other mattes
  if (!is_further(project)) options.learn_room = room_learner(work, inputs.seed, read);
  auto result = matte_clip(folder, read.capture, read.cameras, read.track, model, options, progress, stop);
  if (result && result->report.room && !is_learnt(*result->report.room))
    std::filesystem::remove(room_path(work), ignored);
  return result;
}

}  // namespace likeness
