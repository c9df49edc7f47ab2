#include "skinning/gpu/shader_program.h"

#include <stdexcept>

namespace gelenk {
namespace {

std::string_view findText(ShaderFolder folder, std::string_view name) {
  for (const ShaderText& file : folder)
    if (file.name == name) return file.text;
  for (const ShaderText& file : skinningShaders())
    if (file.name == name) return file.text;
  throw std::logic_error("no shader is called " + std::string(name));
}

std::string withIncludes(ShaderFolder folder, std::string_view name) {
  constexpr std::string_view directive = "#include \"";
  std::string text(findText(folder, name));
  for (std::size_t at; (at = text.find(directive)) != std::string::npos;) {
    const std::size_t start = at + directive.size(), end = text.find('"', start);
    text.replace(at, end + 1 - at, withIncludes(folder, text.substr(start, end - start)));
  }
  return text;
}

std::string header(std::string_view defines) {
  std::string text = glslHeader;
  while (!defines.empty()) {
    const std::size_t end = std::min(defines.find(' '), defines.size());
    if (end > 0) text += "#define " + std::string(defines.substr(0, end)) + " 1\n";
    defines.remove_prefix(std::min(end + 1, defines.size()));
  }
  return text;
}

using LogOf = void (*)(GLuint, GLsizei, GLsizei*, GLchar*);
std::string logOf(GLuint object, LogOf get) {
  std::string log(4096, '\0');
  GLsizei length = 0;
  get(object, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(length);
  return log;
}

/// Compiles and attaches; the shader object goes with the program.
void attach(GLuint program, GLenum stage, const ProgramText& text, std::string_view name) {
  const std::string source = header(text.defines) + withIncludes(text.folder, name);
  const char* pointer = source.c_str();
  const GLuint shader = glCreateShader(stage);
  glShaderSource(shader, 1, &pointer, nullptr);
  glCompileShader(shader);
  glAttachShader(program, shader);
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  const std::string log =
      logOf(shader, [](GLuint o, GLsizei n, GLsizei* l, GLchar* t) { glGetShaderInfoLog(o, n, l, t); });
  glDeleteShader(shader);
  if (!compiled) throw std::runtime_error("the shader " + std::string(name) + " does not compile: " + log);
}

}  // namespace

ShaderProgram::ShaderProgram(const ProgramText& text) : program_(GlProgram::create()) {
  attach(program_, GL_VERTEX_SHADER, text, text.vertex);
  attach(program_, GL_FRAGMENT_SHADER, text, text.fragment);
  if (!text.captured.empty())
    glTransformFeedbackVaryings(program_, static_cast<GLsizei>(text.captured.size()), text.captured.data(),
                                GL_INTERLEAVED_ATTRIBS);
  glLinkProgram(program_);
  GLint linked = GL_FALSE;
  glGetProgramiv(program_, GL_LINK_STATUS, &linked);
  if (!linked)
    throw std::runtime_error(
        "the shaders " + std::string(text.vertex) + " and " + std::string(text.fragment) + " do not link: " +
        logOf(program_, [](GLuint o, GLsizei n, GLsizei* l, GLchar* t) { glGetProgramInfoLog(o, n, l, t); }));
}

void ShaderProgram::bindBlock(const char* block, GLuint binding) const {
  const GLuint index = glGetUniformBlockIndex(program_, block);
  if (index != GL_INVALID_INDEX) glUniformBlockBinding(program_, index, binding);
}

void ShaderProgram::bindSampler(const char* sampler, GLint unit) const {
  use();
  const GLint location = uniform(sampler);
  if (location >= 0) glUniform1i(location, unit);
}

}  // namespace gelenk
