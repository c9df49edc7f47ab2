#pragma once

#include <functional>
#include <string>

#include "solvers/lab/comparison.h"

namespace gelenk {

struct ReportStyle {
  std::string version;                                           ///< of the program
  std::string commandLine;                                       ///< as typed
  std::function<std::string(const std::string& solver)> colour;  ///< "#rrggbb"
};

struct Report {
  std::string note;   ///< for the user where something is missing, such as gnuplot; empty otherwise
  std::string table;  ///< the summary for the terminal, one line a set and solver
};

/// Writes summary.json and report.html (self-contained; plots as SVG drawn by gnuplot) of the results into
/// the folder.
Report writeReport(const std::string& folder, const Results& results, const ReportStyle& style);

/// Runs gnuplot on a script that begins with `set terminal svg`; the SVG text, or empty where gnuplot is
/// absent or fails.
std::string plotSvg(const std::string& script, int width, int height);

/// Name of the processor, compiler and its flags, and library versions, one "key: value" a line.
std::string machineFacts();

}  // namespace gelenk
