#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "apps/document/document.h"

namespace gelenk {

// A document as JSON, format version 2 (docs/formats/scene.md). Files of version 1 are read as well. Doubles
// read back as exactly the same values; joints, limbs and solvers are written by name. model: the one that
// readModelReference names, without edits; the document keeps only what differs from it.

std::string formatScene(const Document& document, const Model& model);
/// Temporary file and rename. Throws std::runtime_error with the system's reason.
void writeScene(const std::string& path, const Document& document, const Model& model);

/// The model that a scene names, read without opening it. Throws ParseError.
ModelReference parseModelReference(std::string_view text, const std::string& file);
ModelReference readModelReference(const std::string& path);

/// Throws ParseError naming the entry, what was expected and what was found: q of the wrong length, unknown
/// joints, limbs or solvers, values that are not finite numbers, quaternions that are not of unit length,
/// weights of another body, a motion of another skeleton.
Document parseScene(std::string_view text, const std::string& file, const Model& model);
Document readScene(const std::string& path, const Model& model);

struct Opened {
  std::shared_ptr<const Model> model;
  Document document;
};
bool isScene(const std::string& nameOrFile);  ///< by its ending, .json
/// Where a scene of that name is saved, so that it may be opened again: .json is added.
std::string scenePathOf(const std::string& name);
/// What every command opens: a scene with its model (other files must not be given then), else a model with
/// all its files, as it begins. Throws ParseError and std::invalid_argument.
enum class Body {
  Wanted,     ///< to be shown: made around the bones where there is none
  AsItComes,  ///< a scene's model has one all the same
};
Opened openDocument(const ModelReference& reference, Body body = Body::Wanted);

}  // namespace gelenk
