#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "skinning/gpu/gl_handle.h"

namespace gelenk {

/// GLSL files embedded at build time (embed_shaders.cmake), found by their file names.
struct ShaderText {
  std::string_view name, text;
};
using ShaderFolder = std::span<const ShaderText>;

ShaderFolder skinningShaders();  ///< skinning/gpu/shaders

/// What a program is made of. Sources are written without a #version line; `#include "name"` is replaced by
/// the text of that file, looked up in the folder and then in skinningShaders().
struct ProgramText {
  ShaderFolder folder;
  std::string_view vertex;
  std::string_view fragment = "";
  std::string_view defines = "";           ///< words to define, separated by blanks
  std::vector<const char*> captured = {};  ///< outputs of transform feedback, interleaved
};

/// A linked program, GLSL 3.30 or in a browser GLSL ES 3.00: shaders keep to what both have.
class ShaderProgram {
 public:
  ShaderProgram() = default;
  /// Throws std::runtime_error with the file's name and the compiler's log.
  explicit ShaderProgram(const ProgramText& text);

  void use() const { glUseProgram(program_); }
  GLuint name() const { return program_; }
  /// -1 where the program does not use it (GL ignores writes to -1).
  GLint uniform(const char* name) const { return glGetUniformLocation(program_, name); }
  /// Ties a uniform block / a sampler to its binding point / texture unit; no effect where the program has
  /// none of that name.
  void bindBlock(const char* block, GLuint binding) const;
  void bindSampler(const char* sampler, GLint unit) const;  ///< makes the program current

 private:
  GlProgram program_;
};

}  // namespace gelenk
