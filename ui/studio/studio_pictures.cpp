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
                  [this, video = contents_->project.options.video,
                   folder = folder_](std::stop_token) -> Background::Delivery {
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
                      if (folder == folder_) clip_picture_ = {0, ++picture_number_, image, missing};
                    };
                  });
}

void Studio::show_frame(FramePicture Studio::*slot, int frame, bool overlay) {
  if (!contents_) return;
  (this->*slot).frame = frame;
  const std::string key = fmt::format("frame {}", slot == &Studio::check_picture_  ? "check"
                                                  : slot == &Studio::face_picture_ ? "face"
                                                                                   : "compare");
  background_.run(key,
                  [this, slot, frame, folder = folder_,
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
                      if (folder == folder_ && (this->*slot).frame == frame)
                        this->*slot = {frame, ++picture_number_, image, missing};
                    };
                  });
}

}  // namespace likeness::ui
