// The inner loops of the flagship; CMake gives this file its instruction set, where the compiler has it.
#if defined(__AVX2__) && defined(__FMA__)
#define GELENK_KERNEL_FUNCTION serialKernelAvx2
#include "solvers/serial/serial_kernel.inl"
#else
#include "solvers/serial/serial_kernel.h"
const gelenk::SerialKernel* gelenk::serialKernelAvx2(int, bool) { return nullptr; }
#endif
