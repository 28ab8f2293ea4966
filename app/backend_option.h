// --backend of the verbs that can compute on a GPU.
#pragma once

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "app/terminal.h"
#include "core/base/result.h"
#include "core/render/backend.h"

namespace likeness::app {

// As add_common_options, but that --backend also takes cuda and auto.
void add_common_options_with_cuda(CLI::App& verb, CommonOptions& options);

// --precision single | bf16
void add_precision_option(CLI::App& verb, FieldPrecision& precision);

struct ChosenBackend {
  std::shared_ptr<Backend> backend;                 // null: the processor
  bool fall_back = false;                           // auto: where the GPU fails, the processor goes on
  FieldPrecision precision = FieldPrecision::bf16;  // as asked for, on either
};
// cuda without a usable GPU is an error that says why; auto is then the processor.
Result<ChosenBackend> chosen_backend(const CommonOptions& options, FieldPrecision precision);
// The same for pictures. Why the processor goes on is said on stderr.
Result<RenderPlace> chosen_place(const CommonOptions& options);

}  // namespace likeness::app
