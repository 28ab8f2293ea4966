// A field's samples as inputs of the field: see rays.h.
#include "core/render/rays.h"

namespace likeness {

void FieldSamples::resize(std::size_t count) {
  for (auto* v : {&x, &y, &z, &dx, &dy, &dz}) v->resize(count);
  view.resize(count);
}

FieldInputs FieldSamples::inputs(const float* conditions, const float* latents) const {
  FieldInputs in;
  in.count = count();
  in.x = x.data(), in.y = y.data(), in.z = z.data();
  in.dx = dx.data(), in.dy = dy.data(), in.dz = dz.data();
  in.view = view.data();
  in.conditions = conditions;
  in.latents = latents;
  in.local = local.empty() ? nullptr : local.data();
  return in;
}

}  // namespace likeness
