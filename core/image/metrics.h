// Picture differences on display-referred values in [0, 1]. Shapes must agree; masks are one channel, > 0
// counts.
#pragma once

#include "core/image/image.h"

namespace likeness {

double mse(const Image& a, const Image& b);                      // mean over pixels and channels
double mse(const Image& a, const Image& b, const Image8& mask);  // over the mask only; NaN for an empty mask
double psnr_from_mse(double mse);                                // dB, peak 1; +inf for 0
double ssim(const Image& a, const Image& b);  // Wang et al. 2004, mean over pixels and channels
double gmsd(const Image& a,
            const Image& b);  // gradient magnitude similarity deviation, Xue et al. 2014; 0 is best

}  // namespace likeness
