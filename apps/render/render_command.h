#pragma once

namespace CLI {
class App;
}

namespace gelenk {

void addRenderCommand(CLI::App& app);  ///< `gelenk render`

}  // namespace gelenk
