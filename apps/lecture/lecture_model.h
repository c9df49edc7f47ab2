#pragma once

#include <string_view>

#include "apps/document/model.h"

namespace gelenk {

/// What "lecture:EXAMPLE" opens: the model of an example of lectureTopics(), at rest in the pose that its
/// scene begins in. Throws std::invalid_argument that lists the examples.
Model lectureModel(std::string_view id);

}  // namespace gelenk
