#include "apps/render/overlay_gl.h"

#include <cstddef>

namespace gelenk {
namespace {

constexpr float depthBias = 2e-4f;  // lines lie on surfaces: drawn this much nearer, in clip space

ShaderProgram program(const char* vertex, const char* fragment, GLuint frameBinding) {
  ShaderProgram result({.folder = rendererShaders(), .vertex = vertex, .fragment = fragment});
  result.bindBlock("Frame", frameBinding);
  result.use();
  glUniform1f(result.uniform("depthBias"), depthBias);
  glUseProgram(0);
  return result;
}

void attribute(GLuint location, GLint components, std::size_t stride, std::size_t at, GLuint divisor) {
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, components, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                        reinterpret_cast<const void*>(at));
  glVertexAttribDivisor(location, divisor);
}

template <class T>
void stream(const GlBuffer& buffer, const std::vector<T>& data) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(),
               GL_STREAM_DRAW);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

}  // namespace

OverlayGl::OverlayGl(GLuint frameBinding)
    : fill_(program("fill.vert", "fill.frag", frameBinding)),
      line_(program("line.vert", "line.frag", frameBinding)),
      point_(program("point.vert", "point.frag", frameBinding)),
      fillArray_(GlVertexArray::create()),
      lineArray_(GlVertexArray::create()),
      pointArray_(GlVertexArray::create()),
      fillBuffer_(GlBuffer::create()),
      lineBuffer_(GlBuffer::create()),
      pointBuffer_(GlBuffer::create()) {
  using Vertex = Overlay::Vertex;
  using Point = Overlay::Point;
  glBindVertexArray(fillArray_);
  glBindBuffer(GL_ARRAY_BUFFER, fillBuffer_);
  attribute(0, 3, sizeof(Vertex), offsetof(Vertex, position), 0);
  attribute(1, 4, sizeof(Vertex), offsetof(Vertex, colour), 0);

  glBindVertexArray(pointArray_);
  glBindBuffer(GL_ARRAY_BUFFER, pointBuffer_);
  attribute(0, 3, sizeof(Point), offsetof(Point, at.position), 1);
  attribute(1, 4, sizeof(Point), offsetof(Point, at.colour), 1);
  attribute(2, 1, sizeof(Point), offsetof(Point, diameter), 1);
  attribute(3, 1, sizeof(Point), offsetof(Point, shape), 1);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void OverlayGl::drawLines(std::size_t first, std::size_t count) {
  using Line = Overlay::Line;
  const std::size_t begin = first * sizeof(Line);
  glBindVertexArray(lineArray_);
  glBindBuffer(GL_ARRAY_BUFFER, lineBuffer_);
  attribute(0, 3, sizeof(Line), begin + offsetof(Line, a.position), 1);
  attribute(1, 4, sizeof(Line), begin + offsetof(Line, a.colour), 1);
  attribute(2, 3, sizeof(Line), begin + offsetof(Line, b.position), 1);
  attribute(3, 4, sizeof(Line), begin + offsetof(Line, b.colour), 1);
  attribute(4, 1, sizeof(Line), begin + offsetof(Line, width), 1);
  attribute(5, 1, sizeof(Line), begin + offsetof(Line, flatEnds), 1);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(count));
}

void OverlayGl::draw(const Overlay& overlay) {
  if (!overlay.fills.empty()) {
    sorted_.clear();
    for (const bool wantOpaque : {true, false})
      for (std::size_t i = 0; i + 2 < overlay.fills.size(); i += 3)
        if ((overlay.fills[i].colour.a >= Overlay::opaqueFrom) == wantOpaque)
          sorted_.insert(sorted_.end(), &overlay.fills[i], &overlay.fills[i] + 3);
    GLsizei opaqueCount = 0;
    while (opaqueCount < static_cast<GLsizei>(sorted_.size()) &&
           sorted_[opaqueCount].colour.a >= Overlay::opaqueFrom)
      opaqueCount += 3;
    stream(fillBuffer_, sorted_);
    fill_.use();
    glBindVertexArray(fillArray_);
    glDrawArrays(GL_TRIANGLES, 0, opaqueCount);
    glDepthMask(GL_FALSE);
    glDrawArrays(GL_TRIANGLES, opaqueCount, static_cast<GLsizei>(sorted_.size()) - opaqueCount);
    glDepthMask(GL_TRUE);
  }
  if (!overlay.lines.empty()) {
    stream(lineBuffer_, overlay.lines);
    line_.use();
    // Translucent ones hide nothing: the rim of one would stand in the way of the next.
    const std::vector<Overlay::Line>& lines = overlay.lines;
    for (std::size_t first = 0, end; first < lines.size(); first = end) {
      const bool solid = lines[first].a.colour.a >= Overlay::opaqueFrom;
      for (end = first + 1; end < lines.size() && (lines[end].a.colour.a >= Overlay::opaqueFrom) == solid;)
        ++end;
      glDepthMask(solid ? GL_TRUE : GL_FALSE);
      drawLines(first, end - first);
    }
    glDepthMask(GL_TRUE);
  }
  if (!overlay.points.empty()) {
    stream(pointBuffer_, overlay.points);
    point_.use();
    glBindVertexArray(pointArray_);
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(overlay.points.size()));
  }
  glBindVertexArray(0);
  glUseProgram(0);
}

}  // namespace gelenk
