// What the studio is started with.
#pragma once

#include <filesystem>

#include "core/lab/study/model_study.h"
#include "core/project/project.h"
#include "core/synth/demo_capture.h"
#include "core/video/record.h"
#include "ui/studio/clip_recorder.h"
#include "ui/studio/pipeline_job.h"

namespace likeness::ui {

struct StudioOptions {
  std::filesystem::path settings;       // file
  std::filesystem::path projects;       // folder of new projects, until another is chosen
  ProjectOptions project;               // of new ones
  DemoOptions demo{.moving_share = 0};  // the demo's camera rests: its avatar needs no COLMAP
  WebcamAccess webcams = real_webcams();
  RecordOptions recording;  // of clips
  double longer_s = 300;    // what "Train longer" adds
  bool previews = true;     // of the running training
  ModelStudyOptions study;  // but what is chosen in its page
  ComputePlace compute;
};

}  // namespace likeness::ui
