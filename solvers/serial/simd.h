#pragma once

// Four doubles at once, in portable C++ with the vector extension that GCC and Clang share. On plain x86-64
// the compiler makes two SSE2 halves of it; functions marked GELENK_SIMD_CLONES exist a second time for AVX2,
// chosen when the program is loaded. Both do the same operations in the same order without contraction, so
// that every machine gives the same bits.

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__AVX2__)
#define GELENK_SIMD_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define GELENK_SIMD_CLONES
#endif
#define GELENK_INLINE __attribute__((always_inline)) inline

namespace gelenk {

typedef double Double4 __attribute__((vector_size(32), aligned(8), may_alias));

/// Four neighbours as one vector, to read or to write; no alignment is asked for.
GELENK_INLINE const Double4& four(const double* p) { return *reinterpret_cast<const Double4*>(p); }
GELENK_INLINE Double4& four(double* p) { return *reinterpret_cast<Double4*>(p); }

}  // namespace gelenk
