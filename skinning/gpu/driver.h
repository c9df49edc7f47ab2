#pragma once

#include <string>

namespace gelenk {

/// GL_RENDERER of the current context, such as "llvmpipe (LLVM 15.0.6, 256 bits)". Belongs beside every
/// timing.
std::string glRenderer();
/// True for llvmpipe, softpipe, SwiftShader: then no multisampling by default, and no claim that "the GPU" is
/// fast.
bool isSoftwareRenderer();

/// Throws std::runtime_error with a sentence unless the version is at least 3.3, e.g. requireOpenGl33(3, 1,
/// "Old GPU").
void requireOpenGl33(int major, int minor, const std::string& renderer);
/// The same for the current context (a window's).
void requireOpenGl33();

}  // namespace gelenk
