// See read_frames.h.
#include "ui/studio/read_frames.h"

#include <filesystem>
#include <utility>

#include "core/image/files.h"
#include "core/video/decode.h"

namespace likeness::ui {

namespace {

Result<VideoFrame> first_frame(const std::filesystem::path& video) {
  auto reader = VideoReader::open(video);
  if (!reader) return reader.error();
  auto frame = reader->next();
  if (!frame) return frame.error();
  if (*frame) return std::move(**frame);
  return Error{ErrorCode::bad_input, "The clip holds no picture.", "Copy it again from the phone.",
               video.string()};
}

}  // namespace

void read_frame(const SessionContext& context, const std::string& key, int frame,
                std::shared_ptr<const FaceOverlay> overlay, FramePicture& into) {
  into.frame = frame;
  context.background.run(key,
                         [context, &into, frame, folder = context.open.folder,
                          overlay = std::move(overlay)](std::stop_token) -> Background::Delivery {
                           auto read = read_image(folder / frame_name(frame));
                           std::shared_ptr<const Image8> image;
                           std::string missing;
                           if (!read) {
                             missing = "No picture of this frame was kept.";
                           } else {
                             image = std::make_shared<const Image8>(overlay && read->channels == 3
                                                                        ? overlay->draw(*read, frame)
                                                                        : std::move(*read));
                           }
                           return [context, &into, frame, folder, image, missing] {
                             if (folder == context.open.folder && into.frame == frame)
                               into = {frame, ++context.pictures, image, missing};
                           };
                         });
}

void read_clip_start(const SessionContext& context, FramePicture& into) {
  into = {};
  context.background.run("clip",
                         [context, &into, video = context.open.contents->project.options.shared.video,
                          folder = context.open.folder](std::stop_token) -> Background::Delivery {
                           std::shared_ptr<const Image8> image;
                           std::string missing;
                           auto frame = first_frame(video);
                           if (frame)
                             image = std::make_shared<const Image8>(std::move(frame->rgb));
                           else
                             missing = frame.error().what + " " + frame.error().fix;
                           return [context, &into, folder, image, missing] {
                             if (folder == context.open.folder)
                               into = {0, ++context.pictures, image, missing};
                           };
                         });
}

}  // namespace likeness::ui
