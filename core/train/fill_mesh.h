// Values known on some vertices of a mesh, spread smoothly to the others.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace likeness {

// T: float or Vec3f. known: (V) 0 = not at all, which is replaced; 1 = certain, which is kept; between, mixed
// with its neighbours. member: (V) only these take part. They become the mean of their neighbours,
// `rounds` times over: a harmonic membrane for many. Where none is known they stay as they are.
template <class T>
void fill_mesh(const std::vector<std::vector<int>>& neighbours, const std::vector<float>& known,
               const std::vector<std::uint8_t>& member, int rounds, std::vector<T>& values) {
  T sum = 0.f * values.front();
  float weight = 0;
  for (std::size_t v = 0; v < values.size(); ++v)
    if (member[v]) sum += known[v] * values[v], weight += known[v];
  if (weight == 0) return;
  const T mean = sum * (1 / weight);
  for (std::size_t v = 0; v < values.size(); ++v)
    if (member[v] && known[v] == 0) values[v] = mean;
  const std::vector<T> given = values;
  for (int round = 0; round < rounds; ++round)
    for (std::size_t v = 0; v < values.size(); ++v) {
      if (!member[v] || known[v] >= 1) continue;
      T around = 0.f * values[v];
      int count = 0;
      for (const int n : neighbours[v])
        if (member[std::size_t(n)]) around += values[std::size_t(n)], ++count;
      if (count > 0) values[v] = known[v] * given[v] + (1 - known[v]) * (1.f / float(count)) * around;
    }
}

}  // namespace likeness
