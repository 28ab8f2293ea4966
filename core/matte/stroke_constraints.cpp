// See stroke_constraints.h.
#include "core/matte/stroke_constraints.h"

#include "core/base/check.h"

namespace likeness {
namespace {

// 8U, 255 where a cover is more than this.
cv::Mat more_than(double share, const Image& cover) {
  const cv::Mat view(cover.height, cover.width, CV_32F, const_cast<float*>(cover.data.data()));
  return view > share;
}

}  // namespace

void constrain_prior(PersonPrior& prior, const StrokeCover& cover) {
  if (cover.empty()) return;
  LIKENESS_CHECK(prior.certain.cols == cover.person.width, "strokes of %d px on a prior of %d px",
                 cover.person.width, prior.certain.cols);
  const cv::Mat person = more_than(kSurelyCovered, cover.person);
  const cv::Mat background = more_than(kSurelyCovered, cover.background);
  if (prior.excluded.empty()) {
    prior.excluded = background;
  } else {  // a painted person outranks a network
    prior.excluded.setTo(0, more_than(0, cover.person));
    prior.excluded |= background;
  }
  prior.certain |= person;
  prior.likely |= person;
  prior.possible |= more_than(0, cover.person);  // with the rim: it must not teach the plate either
  for (cv::Mat* place : {&prior.certain, &prior.likely, &prior.possible}) place->setTo(0, prior.excluded);
}

void hold_cut(cv::Mat& person, const StrokeCover& cover) {
  if (cover.empty()) return;
  LIKENESS_CHECK(person.cols == cover.person.width, "strokes of %d px on a cut of %d px", cover.person.width,
                 person.cols);
  person.setTo(255, more_than(kSurelyCovered, cover.person));
  person.setTo(0, more_than(kSurelyCovered, cover.background));
}

}  // namespace likeness
