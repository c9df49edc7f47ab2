#pragma once

#include <string>

namespace gelenk {

/// What a picture, or a part of it, was made of, byte by byte: where the facts are the same, so is the
/// picture. Values must have no padding.
class Facts {
 public:
  template <class... Values>
  void add(const Values&... values) {
    (bytes_.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
  }
  /// A list's length and its entries.
  template <class List>
  void addAll(const List& list) {
    add(list.size());
    bytes_.append(reinterpret_cast<const char*>(list.data()), list.size() * sizeof *list.data());
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace gelenk
