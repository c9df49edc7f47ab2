#pragma once

namespace gelenk {

enum class Theme { Light, Dark };

}  // namespace gelenk
