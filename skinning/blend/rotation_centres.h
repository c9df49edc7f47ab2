#pragma once

#include <vector>

#include "skinning/skin.h"

namespace gelenk {

/// How far triangles of other weights count for a vertex's centre (Le and Hodgins 2016).
inline constexpr double centreSigma = 0.1;

/// The centre of rotation of every vertex, metres, bind pose (Le and Hodgins 2016): the mean of the places on
/// the skin that have similar weights,
///     c = sum_t k(w, w_t) a_t v_t / sum_t k(w, w_t) a_t,
///     k = sum_{j<l} w_j w_l w_tj w_tl exp(-(w_j w_tl - w_l w_tj)^2 / sigma^2),
/// over triangles t of area a, centroid v and mean weights w_t. Triangles are summed into `bins` x `bins`
/// bins over (w_tj, w_tl) for each pair of bones; a bin holds its sums of a w_tj w_tl exactly and only the
/// exponential is taken at its mean. bins 0: every triangle by itself. Where no triangle counts (vertices of
/// a single bone) the vertex itself; `blended` tells the others.
std::vector<Eigen::Vector3d> rotationCentres(const Skin& skin, std::vector<bool>* blended = nullptr,
                                             int bins = 32);

}  // namespace gelenk
