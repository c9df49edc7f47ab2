#pragma once

#include <algorithm>
#include <memory>
#include <vector>

namespace gelenk {

/// A long list in blocks that its copies share: a copy costs a pointer a block, a change the blocks that it
/// touches. What a history of painted weights is made of.
template <typename T>
class SharedRows {
 public:
  static constexpr int blockSize = 256;

  SharedRows() = default;
  explicit SharedRows(const std::vector<T>& rows) : size_(static_cast<int>(rows.size())) {
    for (auto from = rows.begin(); from != rows.end();) {
      const auto to = from + std::min<std::ptrdiff_t>(blockSize, rows.end() - from);
      blocks_.push_back(std::make_shared<std::vector<T>>(from, to));
      from = to;
    }
  }

  int size() const { return size_; }
  const T& operator[](int row) const { return (*blocks_[row / blockSize])[row % blockSize]; }
  void set(int row, T value) {
    auto& block = blocks_[row / blockSize];
    if (block.use_count() > 1) block = std::make_shared<std::vector<T>>(*block);
    (*block)[row % blockSize] = std::move(value);
  }

  /// Calls found(row, value) for the rows of every block that the two do not share; of equal size.
  template <typename Found>
  void forUnshared(const SharedRows& other, Found found) const {
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      if (blocks_[b] != other.blocks_[b])
        for (std::size_t i = 0; i < blocks_[b]->size(); ++i)
          found(static_cast<int>(b) * blockSize + static_cast<int>(i), (*blocks_[b])[i]);
  }

 private:
  int size_ = 0;
  std::vector<std::shared_ptr<std::vector<T>>> blocks_;
};

}  // namespace gelenk
