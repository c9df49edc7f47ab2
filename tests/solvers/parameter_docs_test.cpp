// The tables of parameters in docs/solvers are those of the catalogue. GELENK_WRITE_DOCS=1 writes them.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>

#include "kinematics/io/text_file.h"
#include "solvers/problem/ik_solver.h"
#include "tests/places.h"

namespace gelenk {
namespace {

const std::string begin = "<!-- parameters of ", end = "<!-- end of parameters -->";

std::string pageOf(std::string_view solver) {
  static const std::map<std::string_view, std::string> shared{{"serial-pose-table", "serial-pose"},
                                                              {"newton-1d", "newton"},
                                                              {"newton-quotient", "newton"},
                                                              {"ball-chain", "fabrik"}};
  const auto found = shared.find(solver);
  return testing::assetFolder() + "/../docs/solvers/" +
         (found == shared.end() ? std::string(solver) : found->second) + ".md";
}

std::string table(const SolverEntry& entry) {
  std::string text = begin + std::string(entry.name) + " -->\n| `" + std::string(entry.name) +
                     "` | default | range | unit | source | meaning |\n|---|---|---|---|---|---|\n";
  for (const Parameter& p : entry.parameters)
    text += "| `" + std::string(p.name) + "` | " + exactNumber(p.value) + " | " + exactNumber(p.lower) +
            " to " + exactNumber(p.upper) + (p.whole ? ", whole" : "") + " | " +
            (p.unit == "1" ? "" : std::string(p.unit)) + " | " + std::string(p.source) + " | " +
            std::string(p.meaning) + " |\n";
  return text + end + "\n";
}

TEST(Docs, EverySolversPageHasItsTableOfParameters) {
  for (const SolverEntry& entry : solverCatalogue()) {
    if (entry.parameters.empty()) continue;
    const std::string path = pageOf(entry.name), wanted = table(entry);
    ASSERT_TRUE(std::filesystem::exists(path)) << path;
    std::string page = readFile(path);
    if (std::getenv("GELENK_WRITE_DOCS") && page.find(wanted) == std::string::npos) {
      const std::string head = begin + std::string(entry.name) + " -->\n";
      if (const std::size_t at = page.find(head); at != std::string::npos)
        page.replace(at, page.find(end, at) + end.size() + 1 - at, wanted);
      else
        page += "\n" + wanted;
      writeFile(path, page);
    }
    EXPECT_NE(page.find(wanted), std::string::npos) << path << " should hold\n" << wanted;
  }
}

}  // namespace
}  // namespace gelenk
