// Drawing plots.
#include "core/lab/study/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/image/page_canvas.h"

namespace likeness {
namespace {

constexpr int kWidth = 1040, kHeight = 560, kLegend = 260;
constexpr PageBox kField{84, 56, kWidth - 84 - kLegend - 24, kHeight - 56 - 70};
constexpr PageColour kColours[] = {{31, 119, 180},  {255, 127, 14}, {44, 160, 44},   {214, 39, 40},
                                   {148, 103, 189}, {140, 86, 75},  {227, 119, 194}, {90, 90, 90},
                                   {160, 160, 20},  {23, 190, 207}};

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  bool log = false;

  void extend(double v) { low = std::min(low, v), high = std::max(high, v); }
  void widen(double share) {
    if (!(high >= low)) low = log ? 1 : 0, high = log ? 10 : 1;
    if (log) {
      const double factor = std::max(1.02, std::pow(high / low, share));
      low /= factor, high *= factor;
    } else {
      const double more = std::max(share * (high - low), 1e-3 + 0.01 * std::abs(high));
      low -= more, high += more;
    }
  }
  double share(double v) const {
    return log ? std::log(v / low) / std::log(high / low) : (v - low) / (high - low);
  }
};

bool is_drawn(const Vec2d& p, bool log_x) {
  return std::isfinite(p.x()) && std::isfinite(p.y()) && (!log_x || p.x() > 0);
}

struct Axes {
  Range x, y;
  Vec2d place(const Vec2d& p) const {
    return {kField.x + x.share(p.x()) * kField.width, kField.y + (1 - y.share(p.y())) * kField.height};
  }
};

void draw_axes(PageCanvas& page, const Plot& plot, const Axes& axes) {
  const PageText small{.size = 15};
  for (const double tick : plot_ticks(axes.x.low, axes.x.high, 8, plot.log_x)) {
    const double x = kField.x + axes.x.share(tick) * kField.width;
    page.line(x, kField.y, x, kField.y + kField.height, kRule);
    const std::string label = fmt::format("{:g}", tick);
    page.text(int(x) - page.text_width(label, small) / 2, kField.y + kField.height + 8, label, small);
  }
  for (const double tick : plot_ticks(axes.y.low, axes.y.high, 8, false)) {
    const double y = kField.y + (1 - axes.y.share(tick)) * kField.height;
    page.line(kField.x, y, kField.x + kField.width, y, kRule);
    const std::string label = fmt::format("{:g}", tick);
    page.text(kField.x - 8 - page.text_width(label, small), int(y) - 8, label, small);
  }
  page.frame(kField, kPale);
  page.text(kField.x, 12, plot.title, {.size = 20, .bold = true});
  page.text(kField.x + kField.width / 2 - page.text_width(plot.x_label, {}) / 2,
            kField.y + kField.height + 36, plot.x_label);
  page.text(8, kField.y - 24, plot.y_label, small);
}

// other: the colours are used a second time.
void draw_mark(PageCanvas& page, const Vec2d& at, const PageColour& colour, bool other) {
  page.fill({int(at.x()) - 4, int(at.y()) - 4, 9, 9}, colour);
  if (other) page.fill({int(at.x()) - 2, int(at.y()) - 2, 5, 5}, kWhite);
}

}  // namespace

std::vector<double> plot_ticks(double low, double high, int most, bool log) {
  std::vector<double> ticks;
  if (!(high > low) || most < 1 || (log && low <= 0)) return ticks;
  if (log) {
    for (double decade = std::pow(10, std::floor(std::log10(low))); decade <= high; decade *= 10)
      for (const double step : {1, 2, 5})
        if (decade * step >= low && decade * step <= high) ticks.push_back(decade * step);
    if (ticks.size() >= 2) return ticks;
    ticks.clear();
  }
  const double rough = (high - low) / most, power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double round : {1.0, 2.0, 5.0})
    if (round * power >= rough) {
      step = round * power;
      break;
    }
  for (double i = std::ceil(low / step); i * step <= high; ++i) ticks.push_back(i * step);
  return ticks;
}

Image8 draw_plot(const Plot& plot) {
  Axes axes;
  axes.x.log = plot.log_x;
  for (const PlotSeries& series : plot.series)
    for (const Vec2d& p : series.points)
      if (is_drawn(p, plot.log_x)) axes.x.extend(p.x()), axes.y.extend(p.y());
  axes.x.widen(0.06), axes.y.widen(0.06);
  PageCanvas page(kWidth, kHeight);
  draw_axes(page, plot, axes);
  const int series = int(plot.series.size()), room = kHeight - kField.y - 16;
  const int row_height = std::clamp(room / std::max(1, series), 18, 26);
  int row = 0;
  for (const PlotSeries& series : plot.series) {
    const PageColour& colour = kColours[std::size_t(row) % std::size(kColours)];
    const bool other = std::size_t(row) / std::size(kColours) % 2 == 1;
    const Vec2d* before = nullptr;
    for (const Vec2d& p : series.points) {
      if (!is_drawn(p, plot.log_x)) continue;
      const Vec2d at = axes.place(p);
      if (before != nullptr) {
        const Vec2d from = axes.place(*before);
        page.line(from.x(), from.y(), at.x(), at.y(), colour, 2);
      }
      draw_mark(page, at, colour, other);
      before = &p;
    }
    const int x = kField.x + kField.width + 20, y = kField.y + 8 + row_height * row;
    draw_mark(page, {x + 7.0, y + 10.0}, colour, other);
    page.text(x + 22, y, series.name, {.size = 16});
    ++row;
  }
  return page.finish(kHeight);
}

}  // namespace likeness
