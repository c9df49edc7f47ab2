#include <cstdio>
#include <string>

namespace user {
bool posePanda(const std::string& solverName);
double dragHand();
double skinTriangle();
std::string complaintAbout(const std::string& solverName);
}  // namespace user

/// Exit status: the number of claims that do not hold.
int main() {
  int failures = 0;
  const auto claim = [&](bool holds, const char* what) {
    if (!holds) ++failures, std::printf("does not hold: %s\n", what);
  };
  claim(user::posePanda("default"), "the pose solver finds a pose of the Panda");
  claim(user::posePanda("lm-chan"), "Levenberg-Marquardt finds it too");
  claim(user::dragHand() < 0.01, "a dragged hand follows to 1 cm");
  claim(user::skinTriangle() < 1e-12, "a skin follows its joint");
  const std::string ceres = user::complaintAbout("ceres-lm");
  claim(ceres.empty() || ceres.find("needs Ceres Solver") != std::string::npos,
        "a missing solver says what it needs");
  std::printf("solver of Ceres: %s\n", ceres.empty() ? "there" : ceres.c_str());
  return failures;
}
