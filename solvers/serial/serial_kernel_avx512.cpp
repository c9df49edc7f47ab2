// The inner loops of the flagship; CMake gives this file its instruction set, where the compiler has it.
#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__FMA__)
#define GELENK_KERNEL_FUNCTION serialKernelAvx512
#include "solvers/serial/serial_kernel.inl"
#else
#include "solvers/serial/serial_kernel.h"
const gelenk::SerialKernel* gelenk::serialKernelAvx512(int, bool) { return nullptr; }
#endif
