// Plots of a study's figures, as pictures.
#pragma once

#include <string>
#include <vector>

#include "core/base/linalg.h"
#include "core/image/image.h"

namespace likeness {

struct PlotSeries {
  std::string name;
  std::vector<Vec2d> points;  // that are joined in their order; a single one stands alone
};

struct Plot {
  std::string title, x_label, y_label;
  bool log_x = false;  // then every x > 0
  std::vector<PlotSeries> series;
};

// Where gridlines are drawn: round numbers within [low, high], about `most` of them; with `log` 1, 2 and 5
// times powers of ten.
std::vector<double> plot_ticks(double low, double high, int most, bool log);

// 1040 x 560 px, three channels; points that are not finite are left out.
Image8 draw_plot(const Plot& plot);

}  // namespace likeness
