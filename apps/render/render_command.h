#pragma once

namespace gelenk {

class Command;

void addRenderCommand(Command& app);  ///< `gelenk render`

}  // namespace gelenk
