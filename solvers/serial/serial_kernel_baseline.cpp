// The inner loops of the flagship with the instructions that the whole build may use.
#define GELENK_KERNEL_FUNCTION serialKernelBaseline
#include "solvers/serial/serial_kernel.inl"
