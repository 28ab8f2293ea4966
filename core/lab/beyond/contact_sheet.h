// Pictures of one size side by side, to be looked at: a column for each case.
#pragma once

#include <vector>

#include "core/image/image.h"

namespace likeness {

class ContactSheet {
 public:
  // A column, from the top; all columns have as many pictures, of one size, with three channels.
  void add(const std::vector<const Image8*>& column);
  // At most this many columns beside each other; the rest goes below. Empty without any column.
  Image8 picture(int most_columns = 8) const;

 private:
  std::vector<std::vector<Image8>> columns_;
};

}  // namespace likeness
