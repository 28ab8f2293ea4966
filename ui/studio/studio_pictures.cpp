// Pictures of the clip's frames, read in the background: see studio.h.
#include "ui/studio/studio.h"

#include <fmt/format.h>

#include <utility>

#include "core/image/files.h"

namespace likeness::ui {

namespace fs = std::filesystem;

void Studio::read_clip_picture() {
  clip_picture_ = {};
  background_.run("clip",
                  [this, video = open_.contents->project.options.video,
                   folder = open_.folder](std::stop_token) -> Background::Delivery {
                    std::shared_ptr<const Image8> image;
                    std::string missing;
                    auto reader = VideoReader::open(video);
                    if (reader) {
                      auto frame = reader->next();
                      if (frame && *frame) image = std::make_shared<const Image8>(std::move((*frame)->rgb));
                    } else {
                      missing = reader.error().what;
                    }
                    return [this, folder, image, missing] {
                      if (folder == open_.folder) clip_picture_ = {0, ++pictures_, image, missing};
                    };
                  });
}

void Studio::show_frame(FramePicture Studio::*slot, int frame, bool overlay) {
  if (!open_.contents) return;
  (this->*slot).frame = frame;
  const std::string key = fmt::format("frame {}", slot == &Studio::check_picture_  ? "check"
                                                  : slot == &Studio::face_picture_ ? "face"
                                                                                   : "compare");
  background_.run(key,
                  [this, slot, frame, folder = open_.folder,
                   draw = overlay ? overlay_ : nullptr](std::stop_token) -> Background::Delivery {
                    auto read = read_image(folder / frame_name(frame));
                    std::shared_ptr<const Image8> image;
                    std::string missing;
                    if (!read) {
                      missing = "No picture of this frame was kept.";
                    } else {
                      image = std::make_shared<const Image8>(
                          draw && read->channels == 3 ? draw->draw(*read, frame) : std::move(*read));
                    }
                    return [this, slot, frame, folder, image, missing] {
                      if (folder == open_.folder && (this->*slot).frame == frame)
                        this->*slot = {frame, ++pictures_, image, missing};
                    };
                  });
}

}  // namespace likeness::ui
