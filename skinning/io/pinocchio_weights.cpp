#include "skinning/io/pinocchio_weights.h"

#include <cmath>
#include <stdexcept>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

std::string counted(std::size_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

/// Rows of a text whose lines, trailing blank ones aside, all hold one row.
struct Row {
  int line;
  std::string_view text;
};
std::vector<Row> splitRows(std::string_view text, const std::string& file) {
  std::vector<Row> rows;
  const auto lines = splitLines(plainText(text, file));
  for (std::size_t n = 0; n < lines.size(); ++n)
    if (lines[n].find_first_not_of(" \t\r") != std::string_view::npos)
      rows.push_back({static_cast<int>(n) + 1, lines[n]});
  return rows;
}

void checkRowCount(const std::string& file, std::size_t rows, int vertexCount,
                   const std::string& explanation) {
  if (rows != static_cast<std::size_t>(vertexCount))
    throw ParseError(file, 0, counted(vertexCount, "row") + ", one for each vertex of the mesh",
                     std::to_string(rows) + explanation);
}

BoneWeights parseRows(const std::vector<Row>& rows, const std::string& file, int boneCount) {
  BoneWeights weights(rows.size(), boneCount);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto words = splitWords(rows[r].text);
    if (words.size() != static_cast<std::size_t>(boneCount))
      throw ParseError(file, rows[r].line, counted(boneCount, "weight") + ", one for each joint but the root",
                       std::to_string(words.size()));
    double sum = 0.0;
    for (int k = 0; k < boneCount; ++k) {
      const auto value = parseNumber(words[k]);
      if (!value || *value < 0.0)
        throw ParseError(file, rows[r].line, "a weight that is finite and not negative",
                         value ? "'" + std::string(words[k]) + "'" : badNumber(words[k]));
      sum += weights(r, k) = *value;
    }
    if (!(sum > 0.0)) throw ParseError(file, rows[r].line, "at least one positive weight", "only zeros");
    if (!std::isfinite(sum)) throw ParseError(file, rows[r].line, "weights with a finite sum", "an overflow");
  }
  return weights;
}

}  // namespace

BoneWeights parsePinocchioWeights(std::string_view text, const std::string& file, int boneCount,
                                  int vertexCount) {
  const auto rows = splitRows(text, file);
  if (rows.empty()) throw ParseError(file, 0, "rows of weights", "none");
  checkRowCount(file, rows.size(), vertexCount, "");
  return parseRows(rows, file, boneCount);
}

BoneWeights readPinocchioWeights(const std::string& path, int boneCount, int vertexCount) {
  return parsePinocchioWeights(readFile(path), path, boneCount, vertexCount);
}

BoneWeights readPinocchioWeights(const std::string& path, int boneCount, const Mesh& mesh) {
  const std::string text = readFile(path);
  const auto rows = splitRows(text, path);
  const int vertices = static_cast<int>(mesh.positions.size());
  std::string explanation;
  if (const int unused = topology(mesh).unreferencedVertices;
      unused > 0 && rows.size() + unused == mesh.positions.size())
    explanation = "; the mesh has " + std::to_string(unused) + (unused == 1 ? " vertex" : " vertices") +
                  " without a face" +
                  ", as many as are missing: Pinocchio drops them; remove them from the OBJ";
  checkRowCount(path, rows.size(), vertices, explanation);
  return parseRows(rows, path, boneCount);
}

std::string formatPinocchioWeights(const BoneWeights& weights) {
  std::string text;
  for (Eigen::Index r = 0; r < weights.rows(); ++r)
    for (Eigen::Index k = 0; k < weights.cols(); ++k)
      text += exactNumber(weights(r, k)) + (k + 1 < weights.cols() ? ' ' : '\n');
  return text;
}

SparseWeights jointWeights(const BoneWeights& boneWeights, const Skeleton& skeleton) {
  if (boneWeights.cols() != skeleton.jointCount() - 1)
    throw std::invalid_argument("the weights have " + std::to_string(boneWeights.cols()) +
                                " columns, the skeleton has " + std::to_string(skeleton.jointCount() - 1) +
                                " bones");
  SparseWeights weights(boneWeights.rows());
  for (Eigen::Index v = 0; v < boneWeights.rows(); ++v)
    for (int j = 1; j < skeleton.jointCount(); ++j)
      if (boneWeights(v, j - 1) != 0.0) weights[v].emplace_back(skeleton.parent(j), boneWeights(v, j - 1));
  return weights;
}

BoneWeights boneWeights(const SparseWeights& jointWeights, const Skeleton& skeleton) {
  if (skeleton.jointCount() < 2)
    throw std::invalid_argument("a skeleton of one joint has no bone to carry weights");
  BoneWeights weights = BoneWeights::Zero(jointWeights.size(), skeleton.jointCount() - 1);
  for (std::size_t v = 0; v < jointWeights.size(); ++v)
    for (const auto& [joint, weight] : jointWeights[v]) {
      const int child = skeleton.children(joint).empty() ? joint : skeleton.children(joint).front();
      weights(v, child - 1) += weight;
    }
  return weights;
}

BoneWeights boneWeights(const std::vector<Influences>& influences, const Skeleton& skeleton) {
  SparseWeights weights(influences.size());
  for (std::size_t v = 0; v < influences.size(); ++v)
    for (int k = 0; k < 4; ++k)
      if (influences[v].weights[k] > 0.0)
        weights[v].emplace_back(influences[v].joints[k], influences[v].weights[k]);
  return boneWeights(weights, skeleton);
}

BoneWeights boneTable(const SparseWeights& bones, int jointCount) {
  BoneWeights table = BoneWeights::Zero(static_cast<Eigen::Index>(bones.size()), jointCount - 1);
  for (std::size_t v = 0; v < bones.size(); ++v)
    for (const auto& [end, weight] : bones[v]) table(static_cast<Eigen::Index>(v), end - 1) += weight;
  return table;
}

}  // namespace gelenk
