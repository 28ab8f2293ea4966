// The verbs of the command line. Each function adds one verb to the parser; running it stores the exit code.
#pragma once

#include <CLI/CLI.hpp>

namespace likeness::app {

void add_build_commands(CLI::App& program, int& exit_code);  // build, import, align, fit, train
void add_check_command(CLI::App& program, int& exit_code);
void add_track_command(CLI::App& program, int& exit_code);
void add_attribute_command(CLI::App& program, int& exit_code);
void add_card_command(CLI::App& program, int& exit_code);
void add_clips_command(CLI::App& program, int& exit_code);
void add_care_commands(CLI::App& program, int& exit_code);  // relink, repair, delete
void add_eval_command(CLI::App& program, int& exit_code);
void add_render_command(CLI::App& program, int& exit_code);
void add_drive_command(CLI::App& program, int& exit_code);
void add_study_command(CLI::App& program, int& exit_code);  // study PROJECT, and those below
void add_truth_study(CLI::App& study, int& exit_code);
void add_track_study(CLI::App& study, int& exit_code);
void add_camera_study(CLI::App& study, int& exit_code);
void add_face_study(CLI::App& study, int& exit_code);
void add_kind_study(CLI::App& study, int& exit_code);
void add_beyond_study(CLI::App& study, int& exit_code);
void add_bench_command(CLI::App& program, int& exit_code);
void add_record_command(CLI::App& program, int& exit_code);
void add_demo_command(CLI::App& program, int& exit_code);
void add_doctor_command(CLI::App& program, int& exit_code);

}  // namespace likeness::app
