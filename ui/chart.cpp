// vtkChartXY: see chart.h.
#include "ui/chart.h"

#include <vtkAxis.h>
#include <vtkBrush.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkContextActor.h>
#include <vtkContextScene.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPen.h>
#include <vtkPlot.h>
#include <vtkPlotPoints.h>
#include <vtkRenderer.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <algorithm>

#include "ui/theme.h"
#include "ui/vtk_view.h"

namespace likeness::ui {

struct TrainingChart::Impl {
  VtkView view{VtkView::Hand::chart};
  vtkNew<vtkChartXY> chart;
  vtkNew<vtkContextActor> actor;
  vtkNew<vtkTable> training, held_out;
  vtkPlot *training_plot = nullptr, *held_out_plot = nullptr;
  std::size_t points = 0, scores = 0;
  double last_s = -1;
  bool dark = false, of_person = false;
  float scale = 0;
  int width = 0, height = 0;  // px, when last drawn
};

namespace {

void make_columns(vtkTable* table, const char* name) {
  vtkNew<vtkFloatArray> seconds, psnr;
  seconds->SetName("s");
  psnr->SetName(name);
  table->AddColumn(seconds);
  table->AddColumn(psnr);
}

void fill(vtkTable* table, std::size_t rows, const auto& seconds, const auto& psnr) {
  auto* x = vtkFloatArray::SafeDownCast(table->GetColumn(0));
  auto* y = vtkFloatArray::SafeDownCast(table->GetColumn(1));
  x->SetNumberOfTuples(vtkIdType(rows));
  y->SetNumberOfTuples(vtkIdType(rows));
  for (std::size_t i = 0; i < rows; ++i) {
    x->SetValue(vtkIdType(i), float(seconds(i)));
    y->SetValue(vtkIdType(i), float(psnr(i)));
  }
  x->Modified();
  y->Modified();
  table->Modified();
}

void set_letters(vtkTextProperty* text, const ImVec4& ink, float size) {
  if (const std::string file = letter_file(); !file.empty()) {
    text->SetFontFamily(VTK_FONT_FILE);
    text->SetFontFile(file.c_str());
  }
  text->SetColor(ink.x, ink.y, ink.z);
  text->SetFontSize(int(size));
  text->SetBold(false);
}

void set_ink(vtkPen* pen, const ImVec4& c, float width) {
  pen->SetColorF(c.x, c.y, c.z);
  pen->SetWidth(width);
}

}  // namespace

TrainingChart::TrainingChart() : impl_(std::make_unique<Impl>()) {
  Impl& my = *impl_;
  make_columns(my.training, "Training frames");
  make_columns(my.held_out, "Held-out frame");
  my.training_plot = my.chart->AddPlot(vtkChart::LINE);
  my.training_plot->SetInputData(my.training, 0, 1);
  my.held_out_plot = my.chart->AddPlot(vtkChart::LINE);
  my.held_out_plot->SetInputData(my.held_out, 0, 1);
  vtkPlotPoints::SafeDownCast(my.held_out_plot)->SetMarkerStyle(vtkPlotPoints::CIRCLE);
  my.training_plot->SetVisible(false);
  my.held_out_plot->SetVisible(false);
  my.chart->SetShowLegend(true);
  my.chart->GetLegend()->SetHorizontalAlignment(vtkChartLegend::RIGHT);
  my.chart->GetLegend()->SetVerticalAlignment(vtkChartLegend::BOTTOM);
  my.chart->GetLegend()->SetInline(true);
  my.chart->GetAxis(vtkAxis::BOTTOM)->SetTitle("seconds of training");
  my.chart->GetAxis(vtkAxis::LEFT)->SetTitle("PSNR, dB");
  my.actor->GetScene()->AddItem(my.chart);
  my.actor->GetScene()->SetRenderer(my.view.renderer());
  my.view.renderer()->AddActor(my.actor);
}

TrainingChart::~TrainingChart() = default;

void TrainingChart::set(std::span<const TrainStatus> training, std::span<const HeldOutScore> held_out,
                        bool of_person) {
  Impl& my = *impl_;
  const double last = training.empty() ? -1 : training.back().seconds;
  if (training.size() == my.points && held_out.size() == my.scores && last == my.last_s &&
      of_person == my.of_person)
    return;
  my.of_person = of_person;
  my.held_out_plot->SetLabel(of_person ? "Held-out frame, the person alone" : "Held-out frame");
  my.points = training.size(), my.scores = held_out.size(), my.last_s = last;
  fill(
      my.training, training.size(), [&](std::size_t i) { return training[i].seconds; },
      [&](std::size_t i) { return training[i].train_psnr_db; });
  fill(
      my.held_out, held_out.size(), [&](std::size_t i) { return held_out[i].training_s; },
      [&](std::size_t i) { return held_out[i].psnr_db; });
  // A line of one point has no extent, which VTK's axes cannot handle.
  my.training_plot->SetVisible(training.size() >= 2);
  my.held_out_plot->SetVisible(held_out.size() >= 2);
  my.chart->RecalculateBounds();
  my.view.touch();
}

void TrainingChart::draw(const char* name, ImVec2 size) {
  Impl& my = *impl_;
  const Theme& t = theme();
  if (my.dark != t.dark || my.scale != t.scale) {
    my.dark = t.dark, my.scale = t.scale;
    const Palette& p = t.colours;
    my.view.renderer()->SetBackground(p.panel.x, p.panel.y, p.panel.z);
    set_ink(my.training_plot->GetPen(), p.accent, 2 * t.scale);
    set_ink(my.held_out_plot->GetPen(), p.good, 2 * t.scale);
    for (const int side : {vtkAxis::BOTTOM, vtkAxis::LEFT}) {
      vtkAxis* axis = my.chart->GetAxis(side);
      set_ink(axis->GetPen(), p.faint, t.scale);
      set_ink(axis->GetGridPen(), p.line, t.scale);
      for (vtkTextProperty* text : {axis->GetLabelProperties(), axis->GetTitleProperties()})
        set_letters(text, p.faint, 12 * t.scale);
    }
    vtkChartLegend* legend = my.chart->GetLegend();
    set_letters(legend->GetLabelProperties(), p.text, 12 * t.scale);
    legend->GetBrush()->SetColorF(p.panel.x, p.panel.y, p.panel.z, 0.9);
    legend->GetPen()->SetColorF(p.line.x, p.line.y, p.line.z);
    my.view.touch();
  }
  my.view.draw(name, size);
  // VTK rounds an axis's range to ticks that are legible at its length, which is known only once it is drawn.
  if (int(size.x) == my.width && int(size.y) == my.height) return;
  my.width = int(size.x), my.height = int(size.y);
  my.chart->RecalculateBounds();
  my.view.touch();
}

}  // namespace likeness::ui
