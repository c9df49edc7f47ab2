#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "skinning/gpu/gl_handle.h"

namespace gelenk {

/// A linked vertex + fragment program. Sources are GLSL 3.30; `#include "name"` is replaced by embedded shader text.
class ShaderProgram {
 public:
  ShaderProgram() = default;
  /// vertex, fragment: names of embedded files ("skinned.vert"; see embeddedShader). defines: lines put below #version.
  /// captured: outputs for transform feedback, interleaved; fragment may then be empty.
  /// Throws std::runtime_error with the compiler's log.
  ShaderProgram(std::string_view vertex, std::string_view fragment, std::string_view defines = "",
                const std::vector<const char*>& captured = {});

  void use() const { glUseProgram(program_); }
  GLuint name() const { return program_; }
  /// -1 where the program does not use it (GL ignores writes to -1).
  GLint uniform(const char* name) const { return glGetUniformLocation(program_, name); }
  void bindBlock(const char* block, GLuint binding) const;
  void bindSampler(const char* sampler, GLint unit) const;  ///< makes the program current

 private:
  GlProgram program_;
};

/// Text of a file of skinning/gpu/shaders, embedded at build time. Throws std::logic_error if there is none of that name.
std::string_view embeddedShader(std::string_view name);

}  // namespace gelenk
