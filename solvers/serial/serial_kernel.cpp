#include "solvers/serial/serial_kernel.h"

#include <stdexcept>
#include <string>

namespace gelenk {
namespace {

const SerialKernel* find(InstructionSet set, int n, bool prismatic) {
  switch (set) {
    case InstructionSet::Baseline: return serialKernelBaseline(n, prismatic);
    case InstructionSet::Avx2: return serialKernelAvx2(n, prismatic);
    case InstructionSet::Avx512: return serialKernelAvx512(n, prismatic);
  }
  return nullptr;
}

bool processorHas(InstructionSet set) {
#if defined(__x86_64__)
  switch (set) {
    case InstructionSet::Baseline: return true;
    case InstructionSet::Avx2: return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case InstructionSet::Avx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
             __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx2") &&
             __builtin_cpu_supports("fma");
  }
  return false;
#else
  return set == InstructionSet::Baseline;
#endif
}

}  // namespace

bool isAvailable(InstructionSet set) { return processorHas(set) && find(set, 1, true) != nullptr; }

InstructionSet bestInstructionSet() {
  static const InstructionSet best = isAvailable(InstructionSet::Avx512) ? InstructionSet::Avx512
                                     : isAvailable(InstructionSet::Avx2) ? InstructionSet::Avx2
                                                                         : InstructionSet::Baseline;
  return best;
}

const char* toString(InstructionSet set) {
  switch (set) {
    case InstructionSet::Baseline: return "baseline";
    case InstructionSet::Avx2: return "AVX2 + FMA";
    case InstructionSet::Avx512: return "AVX-512";
  }
  return "unknown";
}

const SerialKernel& serialKernel(InstructionSet set, int n, bool prismatic) {
  const SerialKernel* kernel = processorHas(set) ? find(set, n, prismatic) : nullptr;
  if (!kernel)
    throw std::invalid_argument("no kernel for " + std::to_string(n) + " dofs with the instruction set '" +
                                toString(set) + "' here");
  return *kernel;
}

}  // namespace gelenk
