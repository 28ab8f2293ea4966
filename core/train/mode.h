// Which of the models that are compared on one capture is trained: how the head's field depends on the
// expression. DESIGN: K = Kwak & Ko 2024, L = Li 2022.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "core/render/avatar.h"

namespace likeness {

enum class FieldMode {
  static_,    // a head that only moves rigidly
  concat,     // psi concatenated to the features (NeRFace-like)
  hyper,      // psi chooses a slice of a hyper-space (K)
  warp,       // samples mapped back by the head model's deformation, psi concatenated (RigNeRF-like, L)
  warp_hyper  // both the deformation and the slice
};
inline constexpr std::array kFieldModes{FieldMode::static_, FieldMode::concat, FieldMode::hyper,
                                        FieldMode::warp, FieldMode::warp_hyper};
inline constexpr FieldMode kDefaultMode = FieldMode::warp_hyper;

// The parts of a mode.
struct ModeParts {
  bool expression = true;  // the field is given psi
  bool ambient = true;     // as a slice; otherwise concatenated
  bool warp = true;        // samples go through the head model's deformation

  bool operator==(const ModeParts&) const = default;
};
ModeParts mode_parts(FieldMode mode);

std::string_view mode_name(FieldMode mode);  // static, concat, hyper, warp, warp+hyper
std::optional<FieldMode> mode_named(std::string_view name);

// Determined from its fields. A capture without any expression leaves psi empty, and without psi there is no
// slice.
FieldMode mode_of(const Avatar& avatar);

}  // namespace likeness
