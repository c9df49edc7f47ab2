#pragma once

#include "apps/document/model_reference.h"

namespace gelenk {

class Command;

/// --skeleton, --weights, --mapping and --figure: the files that belong to a model's, as `sandbox` takes
/// them.
void addModelOptions(Command& command, Companions& files);

}  // namespace gelenk
