#include "core/lab/beyond/contact_sheet.h"

#include <algorithm>

namespace likeness {

void ContactSheet::add(const std::vector<const Image8*>& column) {
  std::vector<Image8>& kept = columns_.emplace_back();
  for (const Image8* picture : column) kept.push_back(*picture);
}

Image8 ContactSheet::picture(int most_columns) const {
  if (columns_.empty() || columns_.front().empty()) return {};
  const int across = std::min(most_columns, int(columns_.size())), high = int(columns_.front().size());
  const int bands = (int(columns_.size()) + across - 1) / across;
  const int width = columns_.front().front().width, height = columns_.front().front().height;
  Image8 sheet(across * width, bands * high * height, 3, std::uint8_t(255));
  for (std::size_t i = 0; i < columns_.size(); ++i)
    for (std::size_t k = 0; k < columns_[i].size(); ++k) {
      const Image8& from = columns_[i][k];
      const int left = int(i) % across * width, top = (int(i) / across * high + int(k)) * height;
      for (int y = 0; y < height; ++y)
        std::copy_n(from.at(0, y), std::size_t(3) * std::size_t(width), sheet.at(left, top + y));
    }
  return sheet;
}

}  // namespace likeness
