#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

#include "skinning/skin.h"

namespace gelenk {

/// Pinocchio's attachment file: one line a vertex, one column a bone. **Column j belongs to the bone from
/// joint j + 1 to its parent**: a bone is numbered by its child joint, and the root has no column. vertices x
/// (joints - 1).
using BoneWeights = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Throws ParseError: a row with another number of columns than bones, a number that is none, negative or not
/// finite, a row of zeros, and a number of rows that is not vertexCount.
BoneWeights readPinocchioWeights(const std::string& path, int boneCount, int vertexCount);
/// The same for a mesh: where the rows do not fit, the message tells whether the original program's habit of
/// dropping vertices that no face uses explains it.
BoneWeights readPinocchioWeights(const std::string& path, int boneCount, const Mesh& mesh);
/// The same from text; file names it in messages.
BoneWeights parsePinocchioWeights(std::string_view text, const std::string& file, int boneCount,
                                  int vertexCount);

/// Shortest notation that reads back as the same bits.
std::string formatPinocchioWeights(const BoneWeights& weights);

/// Which joint carries each bone: a bone turns about its parent joint, so column j goes to parent(j + 1).
/// Columns of bones with one parent joint become several entries of that joint. boneWeights: vertices x
/// (joints - 1).
SparseWeights jointWeights(const BoneWeights& boneWeights, const Skeleton& skeleton);

/// The other way: each joint's weight goes to the bone to its first child, that of a joint without a child to
/// its own bone.
BoneWeights boneWeights(const SparseWeights& jointWeights, const Skeleton& skeleton);
/// The same of a skin. Reading it back gives the same weights exactly, but for those on joints without a
/// child: these have no column of their own and come back on the parent.
BoneWeights boneWeights(const std::vector<Influences>& influences, const Skeleton& skeleton);
/// Entries (joint at the bone's lower end, weight) as a table: vertices x (joints - 1).
BoneWeights boneTable(const SparseWeights& bones, int jointCount);

}  // namespace gelenk
