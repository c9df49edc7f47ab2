#include "skinning/blend/skin_choice.h"

#include <charconv>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "skinning/blend/limb_chains.h"
#include "skinning/blend/shoulder_lift.h"
#include "skinning/blend/weight_smoothing.h"

namespace gelenk {

SkinChoice parseSkinChoice(std::string_view text) {
  const std::string_view whole = text;
  std::size_t plus = text.find('+');
  SkinChoice choice{.method = skinMethodNamed(text.substr(0, plus)).kind};
  std::set<std::string_view> said;  // twist, layers, smooth: whatever value they have
  while (plus != std::string_view::npos) {
    text.remove_prefix(plus + 1);
    plus = text.find('+');
    const std::string_view word = text.substr(0, plus);
    if (!said.insert(word.substr(0, word.find('='))).second)
      throw std::invalid_argument("'" + std::string(word) + "' in '" + std::string(whole) +
                                  "': said for the second time");
    if (word == "twist" && skinMethod(choice.method).twists) {
      choice.twist = true;
    } else if ((word == "layers" || word == "layers=muscle") && !skinMethod(choice.method).shader.empty()) {
      choice.layers = word == "layers" ? SkinLayers::Volumes : SkinLayers::Muscles;
    } else if (word == "smooth") {
      choice.smoothing = defaultSmoothing;
    } else if (word.starts_with("smooth=")) {
      double millimetres = -1.0;
      const auto [end, error] = std::from_chars(word.data() + 7, word.data() + word.size(), millimetres);
      if (error != std::errc() || end != word.data() + word.size() ||
          !(millimetres >= 0.0 && millimetres <= 200.0))
        throw std::invalid_argument("'" + std::string(word) + "' in '" + std::string(whole) +
                                    "': weights are smoothed over 0 to 200 millimetres");
      choice.smoothing = 1e-3 * millimetres;
    } else {
      throw std::invalid_argument(
          "'" + std::string(word) + "' in '" + std::string(whole) + "' is nothing that '" +
          std::string(skinMethod(choice.method).name) +
          "' can have; there are twist, layers and layers=muscle (of lbs, dqs, cor), smooth and "
          "smooth=MILLIMETRES");
    }
  }
  return choice;
}

std::string toString(const SkinChoice& choice) {
  std::ostringstream text;
  text << skinMethod(choice.method).name;
  if (choice.twist) text << "+twist";
  if (choice.smoothing == defaultSmoothing)
    text << "+smooth";
  else if (choice.smoothing > 0.0)
    text << "+smooth=" << 1e3 * choice.smoothing;
  if (choice.layers != SkinLayers::None)
    text << (choice.layers == SkinLayers::Volumes ? "+layers" : "+layers=muscle");
  return text.str();
}

PreparedSkin prepareSkin(const Skin& skin, const SkinChoice& choice, const Skeleton& skeleton,
                         const Frames& bound) {
  const std::vector<LimbChain> limbs = limbChains(skeleton);
  TwistSpread spread;
  if (choice.twist) {
    std::vector<std::vector<int>> chains;
    for (const LimbChain& limb : limbs) chains.push_back(limb.joints);
    spread = spreadTwist(skeleton, bound, chains);
  }
  PreparedSkin prepared =
      prepareSkin(smoothWeights(skin, choice.smoothing), skinMethod(choice.method), std::move(spread));
  liftShoulderCentres(prepared, skeleton, bound, limbs);
  return prepared;
}

}  // namespace gelenk
