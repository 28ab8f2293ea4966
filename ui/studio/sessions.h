// The studio's sessions, as commands are given them.
#pragma once

#include "ui/studio/direct_session.h"
#include "ui/studio/export_session.h"
#include "ui/studio/mask_session.h"
#include "ui/studio/project_session.h"
#include "ui/studio/record_session.h"
#include "ui/studio/session_context.h"
#include "ui/studio/study_session.h"

namespace likeness::ui {

struct Sessions {
  ProjectSession& project;
  DirectSession& direct;
  MaskSession& masks;
  StudySession& study;
  RecordSession& recorder;
  ExportSession& exports;
  const SessionContext& context;
};

}  // namespace likeness::ui
