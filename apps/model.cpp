#include "apps/model.h"

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>

#include "apps/model_files.h"

namespace gelenk {
namespace {

struct BuiltIn {
  std::string name;
  Model (*make)();
};

const std::vector<BuiltIn>& builtIns() {
  static const std::vector<BuiltIn> table{};
  return table;
}

}  // namespace

std::vector<std::string> builtInModels() {
  std::vector<std::string> names;
  for (const BuiltIn& entry : builtIns()) names.push_back(entry.name);
  return names;
}

Model openModel(const std::string& nameOrFile) {
  for (const BuiltIn& entry : builtIns())
    if (entry.name == nameOrFile) return entry.make();
  if (fileKind(nameOrFile) || std::filesystem::exists(nameOrFile)) return openModelFile(nameOrFile);
  std::string known;
  for (const std::string& name : builtInModels()) known += (known.empty() ? "" : ", ") + name;
  throw std::invalid_argument(fmt::format("no model is called '{}'; there are: {}, and files ending in {}", nameOrFile, known,
                                          knownExtensions()));
}

}  // namespace gelenk
